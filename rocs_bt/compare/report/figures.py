"""Figures of a comparison: statistics of all episodes, and the paths of two planners in the same scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ...catalog import Catalog
from ...record import RunHeader
from ...record.figures.arena import draw_world
from ...record.figures.figure import MUTED
from ...running.header import make_scenery
from ...simulation import compose_scenario
from ..comparison import Comparison, Disagreement
from ..record import EpisodeRecord
from ..replay import scene_by_name
from ..runner import EpisodeRunner
from ..statistics import Floats, cluster_bootstrap, cumulative_incidence, performance_profile, rate, widened
from .page import inline_svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

LIGHT = ("#2f6db4", "#c2410d", "#1f8a5c", "#8a4fb9", "#9a7000", "#c0397d", "#2f8594", "#5f666f")
DARK = ("#7db4f6", "#ff9464", "#55c797", "#c79bf3", "#e0b84b", "#f585b6", "#6fcbd9", "#aab2be")
_LINES: tuple[Any, ...] = ("-", (0, (6, 1.5)), (0, (2, 1.2)), (0, (6, 1.5, 1.5, 1.5)))


def colour(number: int) -> str:
    """Colour of a planner by its index."""
    return LIGHT[number % len(LIGHT)]


def line(number: int) -> dict[str, Any]:
    """Colour and line style of a planner by its index; planners of equal colour differ in style."""
    return {"color": colour(number), "linestyle": _LINES[(number + number // len(LIGHT)) % len(_LINES)]}


def theme() -> str:
    """CSS properties of the planner colours, for light and dark themes."""
    light, dark = (" ".join(f"--planner-{i}: {value};" for i, value in enumerate(values)) for values in (LIGHT, DARK))
    return f":root {{ {light} }}\n@media (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}"


def themed(name: str, svg: str) -> str:
    """SVG figure as an element of the HTML page, with colours that follow the page's light or dark theme."""
    text = inline_svg(name, svg)
    for number, value in enumerate(LIGHT):
        text = text.replace(value, f"var(--planner-{number})")
    return text


_CAUSES = {"success": 1, "collision": 2, "fell": 3}
_OTHER = 4  # any other cause
_POINTS, _RESAMPLES, _BINS = 120, 400, 5
_APART = 0.012  # offset between the error bars of two planners, as a share of the width
_SCENES_FOR_BINS = 10


def incidence(canvas: Canvas, comparison: Comparison, outcome: str) -> None:
    """Plot the share of episodes that have reached an outcome over time, with 95 % bands."""
    axes = canvas.add_subplot()
    at = np.linspace(0.0, comparison.time_limit, _POINTS)

    def curve(resampled: Floats) -> Floats:
        known = resampled[~np.isnan(resampled[..., 0])]
        return cumulative_incidence(known[:, 0], known[:, 1].astype(int), _CAUSES[outcome], at)

    for number, planner in enumerate(comparison.planners):
        value, low, high = cluster_bootstrap(_ends(comparison, planner), curve, resamples=_RESAMPLES)
        low, high = widened(comparison.sample(planner, "success"), value, low, high)
        axes.plot(at, value, drawstyle="steps-post", label=planner, **line(number))
        axes.fill_between(at, low, high, step="post", color=colour(number), alpha=0.12, linewidth=0)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("share of episodes")
    axes.set_xlim(0.0, comparison.time_limit)
    axes.set_ylim(0.0, 1.02 if outcome == "success" else None)
    _legend(canvas, axes)


def profile(canvas: Canvas, comparison: Comparison) -> None:
    """Plot the share of episodes in which a planner's time is within a factor of the fastest one's, over the factor."""
    axes = canvas.add_subplot()
    costs = np.stack([_costs(comparison, planner).ravel() for planner in comparison.planners])
    costs = costs[:, ~np.isnan(costs).any(axis=0)]
    if costs.size:
        ratios = np.geomspace(1.0, 4.0, 200)
        for number, shares in enumerate(performance_profile(costs, ratios)):
            axes.plot(ratios, shares, drawstyle="steps-post", label=comparison.planners[number], **line(number))
    axes.set_xscale("log", base=2)
    axes.set_xticks([1.0, 1.5, 2.0, 3.0, 4.0], ["1", "1.5", "2", "3", "4"])
    axes.minorticks_off()
    axes.set_xlim(1.0, 4.0)
    axes.set_ylim(0.0, 1.02)
    axes.set_xlabel("times the fastest planner's time in the same episode")
    axes.set_ylabel("share of episodes")
    _legend(canvas, axes)


def intervals(canvas: Canvas, comparison: Comparison) -> None:
    """Plot the success rates with 95 % intervals, one row per planner."""
    axes = canvas.add_subplot()
    for number, planner in enumerate(comparison.planners):
        found = comparison.estimate(planner, "success")
        axes.plot([found.low, found.high], [number, number], color=colour(number), lw=2.2, solid_capstyle="butt")
        axes.plot([found.value], [number], "o", color=colour(number), ms=5)
    axes.set_yticks(range(len(comparison.planners)), comparison.planners)
    axes.set_ylim(len(comparison.planners) - 0.5, -0.5)
    axes.set_xlim(-0.02, 1.02)
    axes.set_xlabel("success rate")
    axes.grid(visible=False, axis="y")


def difficulty(canvas: Canvas, comparison: Comparison, measure: str) -> None:
    """Plot success rates with intervals over a difficulty measure, with the scenes in five bins."""
    axes = canvas.add_subplot()
    known = {r.scene: r.difficulty[measure] for r in comparison.records if measure in r.difficulty}
    rows = np.array([i for i, scene in enumerate(comparison.scenes) if scene in known])
    values = np.array([known[comparison.scenes[i]] for i in rows])
    order = np.argsort(values, kind="stable")
    parts, centres = np.array_split(rows[order], _BINS), [part.mean() for part in np.array_split(values[order], _BINS)]
    apart = _APART * (max(centres) - min(centres))
    for number, planner in enumerate(comparison.planners):
        success = comparison.values(planner, "success")
        found = [rate(success[part]) for part in parts]
        ends = np.array([[f.value - f.low, f.high - f.value] for f in found]).T
        at = np.array(centres) + apart * (number - (len(comparison.planners) - 1) / 2.0)
        style = {"marker": "o", "ms": 3.5, "elinewidth": 0.8, "capsize": 2, "label": planner, **line(number)}
        axes.errorbar(at, [f.value for f in found], ends, **style)
    axes.set_xlabel(measure)
    axes.set_ylabel("success rate")
    axes.set_ylim(-0.02, 1.02)
    _legend(canvas, axes)


def difficulties(comparison: Comparison) -> list[str]:
    """Names of the difficulty measures that vary between scenes; none if there are too few scenes for bins."""
    found: dict[str, set[float]] = {}
    for record in comparison.records:
        for name, value in record.difficulty.items():
            found.setdefault(name, set()).add(value)
    enough = len(comparison.scenes) >= _SCENES_FOR_BINS
    return [name for name, values in found.items() if enough and len(values) >= _BINS]


def _ends(comparison: Comparison, planner: str) -> Floats:
    """End time [s] and cause of end of each episode, shape (n, m, 2); NaN if the episode is missing.

    Rows are scenes, or the seeds of a single scene.
    """
    found = np.full((len(comparison.scenes), len(comparison.seeds), 2), np.nan)
    for i, scene in enumerate(comparison.scenes):
        for k, seed in enumerate(comparison.seeds):
            if (record := comparison.find(planner, scene, seed)) is not None:
                found[i, k] = record.sim_time, _cause(record)
    return found if len(comparison.scenes) > 1 else found.swapaxes(0, 1)


def _cause(record: EpisodeRecord) -> int:
    """Cause of an episode's end; 0 (censored) if its time limit ended it, but not if it missed a deadline."""
    if record.outcome == "timeout" and record.sim_time >= record.time_limit - 1e-6:
        return 0
    return _CAUSES.get(record.outcome, _OTHER)


def _costs(comparison: Comparison, planner: str) -> Floats:
    """Times of a planner's episodes [s], shape (n_scenes, n_seeds); +inf for failures, NaN if missing."""
    times, success = comparison.values(planner, "time"), comparison.values(planner, "success")
    return np.where(success == 0.0, np.inf, np.maximum(times, 1e-9))


def _legend(canvas: Canvas, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    canvas.legend(handles, labels, loc="outside upper left", ncols=4, labelcolor=MUTED)


Corner: TypeAlias = npt.NDArray[np.float64]

_MARGIN = 1.0  # [m]
_WIDTH, _LABELS = 3.8, 0.4  # [inch]


def sceneries(scenes: Sequence[str], catalog: Catalog) -> dict[str, RunHeader]:
    """World geometry of scenes, by name of the scene, for figures.

    Raises:
        InputError: A scene no longer exists.
    """
    runner, found = EpisodeRunner(catalog.project), {}
    for scene in dict.fromkeys(scenes):
        prepared = runner.prepare(scene_by_name(scene, catalog))
        found[scene] = make_scenery(prepared.scenario, compose_scenario(prepared.scenario, prepared.catalog))
    return found


def draw_disagreement(
    canvas: Canvas, name: str, found: Disagreement, comparison: Comparison, scenery: RunHeader | None
) -> None:
    """Draw the paths of two episodes of the same scene, with a cross where the failed episode ended.

    Args:
        canvas: Canvas to draw on.
        name: Name of the figure, the prefix of its element ids.
        found: The two episodes.
        comparison: Comparison with all planners, which determines their colours.
        scenery: World geometry; None if not known.
    """
    axes = canvas.add_subplot()
    axes.set_aspect("equal")
    if scenery is not None:
        draw_world(axes, scenery, name)
    for record in (found.winner, found.loser):
        number = comparison.planners.index(record.planner)
        path = record.path.astype(float)
        if not len(path):
            continue
        axes.plot(*path.T, zorder=4, gid=f"{name}-{record.planner}", **line(number))
        axes.plot(*path[0], "o", color=colour(number), ms=3, zorder=5)
        if not record.success:
            axes.plot(*path[-1], "x", color=colour(number), ms=9, mew=2.0, zorder=6, gid=f"{name}-end")
    low, high = _box(found)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


def picture_size(found: Disagreement) -> tuple[float, float]:
    """Width and height of a picture [inch] that fit the paths of both episodes."""
    (width, height) = np.subtract(*reversed(_box(found)))
    return _WIDTH, float(np.clip(_WIDTH * height / width, _WIDTH / 2, 2 * _WIDTH)) + _LABELS


def _box(found: Disagreement) -> tuple[Corner, Corner]:
    """Bounding box of the paths of both episodes with a margin: minimum and maximum x and y [m]."""
    every = np.concatenate([found.winner.path, found.loser.path, np.zeros((0, 2), np.float32)]).astype(float)
    if not len(every):
        return np.array([-_MARGIN, -_MARGIN]), np.array([_MARGIN, _MARGIN])
    return every.min(axis=0) - _MARGIN, every.max(axis=0) + _MARGIN
