"""Figures over all episodes: success and collisions over time, profiles, what difficulty does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...record.figures.figure import MUTED
from ..comparison import Comparison
from ..statistics import Floats, cluster_bootstrap, cumulative_incidence, performance_profile, rate
from .style import colour, line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from ..record import EpisodeRecord

_SUCCESS, _COLLISION, _OTHER = 1, 2, 3
_CAUSES = {"success": _SUCCESS, "collision": _COLLISION}
_POINTS, _RESAMPLES, _BINS = 120, 400, 5
_APART = 0.012  # of the width, between the bars of two planners
_SCENES_FOR_BINS = 10


def incidence(canvas: Canvas, comparison: Comparison, outcome: str) -> None:
    """The share of episodes that have come to an outcome until each moment, with bands of 95 %."""
    axes = canvas.add_subplot()
    at = np.linspace(0.0, comparison.time_limit, _POINTS)

    def curve(drawn: Floats) -> Floats:
        known = drawn[~np.isnan(drawn[..., 0])]
        return cumulative_incidence(known[:, 0], known[:, 1].astype(int), _CAUSES[outcome], at)

    for number, planner in enumerate(comparison.planners):
        value, low, high = cluster_bootstrap(_ends(comparison, planner), curve, resamples=_RESAMPLES)
        axes.plot(at, value, drawstyle="steps-post", label=planner, **line(number))
        axes.fill_between(at, low, high, step="post", color=colour(number), alpha=0.12, linewidth=0)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("share of episodes")
    axes.set_xlim(0.0, comparison.time_limit)
    axes.set_ylim(0.0, 1.02 if outcome == "success" else None)
    _legend(canvas, axes)


def profile(canvas: Canvas, comparison: Comparison) -> None:
    """In what share of episodes a planner is within a factor of the fastest one there."""
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
    """Success rates with their 95 % intervals, a row each."""
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
    """The success rate over a measure of difficulty, in five parts of the scenes, with its interval."""
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
    """The measures of difficulty that differ between scenes, of which there must be enough to be put into parts."""
    found: dict[str, set[float]] = {}
    for record in comparison.records:
        for name, value in record.difficulty.items():
            found.setdefault(name, set()).add(value)
    enough = len(comparison.scenes) >= _SCENES_FOR_BINS
    return [name for name, values in found.items() if enough and len(values) >= _BINS]


def _ends(comparison: Comparison, planner: str) -> Floats:
    """(n, m, 2) When each episode ended, and by what; NaN where there is none. Of a single scene a row is a seed."""
    found = np.full((len(comparison.scenes), len(comparison.seeds), 2), np.nan)
    for i, scene in enumerate(comparison.scenes):
        for k, seed in enumerate(comparison.seeds):
            if (record := comparison.find(planner, scene, seed)) is not None:
                found[i, k] = record.sim_time, _cause(record)
    return found if len(comparison.scenes) > 1 else found.swapaxes(0, 1)


def _cause(record: EpisodeRecord) -> int:
    """Cause of an episode's end; 0 (censored) if only the time limit ended it. A missed deadline is a cause."""
    if record.outcome == "timeout" and record.sim_time >= record.time_limit - 1e-6:
        return 0
    return _CAUSES.get(record.outcome, _OTHER)


def _costs(comparison: Comparison, planner: str) -> Floats:
    """(n_scenes, n_seeds) Times; +inf where it failed, NaN where there is no episode."""
    times, success = comparison.values(planner, "time"), comparison.values(planner, "success")
    return np.where(success == 0.0, np.inf, np.maximum(times, 1e-9))


def _legend(canvas: Canvas, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    canvas.legend(handles, labels, loc="outside upper left", ncols=4, labelcolor=MUTED)
