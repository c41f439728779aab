"""comparison.html: a self-contained page built from episode records."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import msgspec

from ...base.errors import RecordingError
from ...base.files import write_whole
from ...base.words import counted
from ...record import RunHeader
from ...record.figures.figure import make_canvas, render_canvas
from ..cold import Loss, StrengthWalk
from ..comparison import Comparison, Disagreement
from ..key import computing
from ..metric import DEFAULT_METRICS, METRICS, SHARES, Metric, metric
from ..record import EpisodeRecord
from ..replay import both_command, recorded_page, replay_command
from ..verdict import Verdict
from . import figures
from .figures import draw_disagreement, picture_size, theme, themed
from .markdown import extent
from .page import render_page
from .tables import (
    COLD_HEAD,
    cold_rows,
    conclusive_first,
    difference,
    everything,
    headline,
    matrix,
    middle,
    number,
    points,
    standings,
    text,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

PICTURES = 12
"""Maximum number of disagreements for which a picture is drawn; all disagreements are listed."""

_FAILURES = 300  # maximum number of listed failures; the page's data contain all
_DIGITS = 6
_WIDTH, _HEIGHT = 5.6, 3.9  # [inch]


def write_comparison(
    comparison: Comparison,
    path: Path,
    *,
    metrics: Sequence[str] = DEFAULT_METRICS,
    any_time: bool = False,
    sceneries: Callable[[Sequence[str]], Mapping[str, RunHeader]] = lambda scenes: {},
    command: str = "",
    losses: Sequence[Loss] = (),
    walks: Sequence[StrengthWalk] = (),
) -> None:
    """Write the report of a comparison.

    Args:
        comparison: The episodes.
        path: Output HTML file; its folder is created if missing.
        metrics: Metrics of the verdicts and the leaderboard.
        any_time: Whether the verdicts stay valid after a sweep that was stopped because of its results.
        sceneries: Function that returns the world geometry of given scenes, for the figures.
        command: Command line that reproduces the report.
        losses: Losses of a cold comparison.
        walks: Walks outward of a cold comparison.

    Raises:
        RecordingError: The file cannot be written.
        InputError: A metric is unknown, or has no any-time verdict.
    """
    page = render_comparison(
        comparison,
        metrics=metrics,
        any_time=any_time,
        sceneries=sceneries,
        command=command,
        losses=losses,
        walks=walks,
        recorded=partial(_recorded, path.parent),
    )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, page)
    except OSError as error:
        raise RecordingError(f"the report '{path}' cannot be written: {error.strerror}.") from error


def render_comparison(
    comparison: Comparison,
    *,
    metrics: Sequence[str] = DEFAULT_METRICS,
    any_time: bool = False,
    sceneries: Callable[[Sequence[str]], Mapping[str, RunHeader]] = lambda scenes: {},
    command: str = "",
    losses: Sequence[Loss] = (),
    walks: Sequence[StrengthWalk] = (),
    recorded: Callable[..., str] = lambda *episodes: "",
) -> str:
    """Report as HTML; see `write_comparison`.

    `recorded` returns the link to the page of one episode, or of two over each other; empty if there is none yet.
    """
    verdicts = comparison.verdicts(metrics, any_time=any_time)
    rows = standings(comparison, metrics)
    found = [d for a, b in combinations(comparison.planners, 2) for d in comparison.disagreements(a, b)]
    shown = _shown(found)
    worlds = sceneries([each.winner.scene for each in shown])
    failures = [record for record in comparison.records if not record.success]
    data = msgspec.json.encode(exported(comparison, verdicts, losses, walks)).decode().replace("<", "\\u003c")
    return render_page(
        "comparison.html",
        theme=theme(),
        title=headline(rows, verdicts),
        extent=extent(comparison),
        comparison=comparison,
        metrics=[metric(name) for name in metrics],
        all_metrics=METRICS,
        rows=rows,
        verdicts=conclusive_first(verdicts),
        matrices=_matrices(verdicts, [row.planner for row in rows]),
        any_time=any_time,
        cold_head=COLD_HEAD,
        losses=cold_rows(losses),
        walks=walks,
        figures=list(_figures(comparison)),
        pictures=[_picture(i, each, comparison, worlds) for i, each in enumerate(shown)],
        disagreements=found,
        failures=failures[:_FAILURES],
        more=len(failures) - _FAILURES,
        everything=everything(comparison),
        middle=middle(comparison),
        versions=computing(),
        command=command,
        data=data,
        text=text,
        number=number,
        difference=difference,
        points=points,
        counted=counted,
        replay=replay_command,
        both=both_command,
        recorded=recorded,
        shares=SHARES,
    )


def _recorded(folder: Path, *episodes: EpisodeRecord) -> str:
    """Link from a folder to the page of an episode that was played again, or of two; empty if there is none."""
    page = recorded_page(*episodes)
    return quote(Path(os.path.relpath(page, folder)).as_posix()) if page.is_file() else ""


def exported(
    comparison: Comparison,
    verdicts: Sequence[Verdict],
    losses: Sequence[Loss] = (),
    walks: Sequence[StrengthWalk] = (),
) -> dict[str, Any]:
    """Data that a reader can export from the page: a table with one row per episode, verdicts, and losses if any."""
    names = [name for name in METRICS if any(record.metrics.get(name) is not None for record in comparison.records)]
    measures = sorted({name for record in comparison.records for name in record.difficulty})
    columns = ["planner", "family", "scene", "seed", "outcome", "reason", "ended", *names, *measures]
    rows = [
        [r.planner, r.family, r.scene, r.seed, r.outcome, r.reason, _short(r.sim_time)]
        + [_short(r.metrics.get(name)) for name in names]
        + [_short(r.difficulty.get(name)) for name in measures]
        for r in comparison.records
    ]
    found = {"columns": columns, "rows": rows, "verdicts": [verdict.as_dict() for verdict in verdicts]}
    cold = {"cold": [loss.as_dict() for loss in losses], "outward": [walk.as_dict() for walk in walks]}
    return {**found, **{name: values for name, values in cold.items() if values}}


def _matrices(
    verdicts: Sequence[Verdict], planners: Sequence[str]
) -> list[tuple[Metric, list[tuple[str, list[Verdict | None]]]]]:
    """Verdict matrix of each metric, one row per planner; empty for two planners, which form a single pair."""
    names = dict.fromkeys(verdict.metric for verdict in verdicts) if len(planners) > 2 else ()
    squares = [(name, matrix([v for v in verdicts if v.metric == name], planners)) for name in names]
    return [(metric(name), list(zip(planners, square, strict=True))) for name, square in squares]


def _figures(comparison: Comparison) -> Iterator[tuple[str, str, str]]:
    """Draw the figures; yields name, title and SVG of each."""
    planners = len(comparison.planners)
    over_time = [("success", "Success over time"), ("collision", "Collisions over time")]
    if any(record.outcome == "fell" for record in comparison.records):
        over_time.append(("fell", "Falls over time"))
    wanted: list[tuple[str, str, float, Callable[[Canvas], None]]] = [
        (f"{outcome}-over-time", title, _HEIGHT, partial(figures.incidence, comparison=comparison, outcome=outcome))
        for outcome, title in over_time
    ]
    rows: Callable[[Canvas], None] = partial(figures.intervals, comparison=comparison)
    wanted.append(("intervals", "Success rates with 95 % intervals", 1.1 + 0.32 * planners, rows))
    if planners > 1:
        against: Callable[[Canvas], None] = partial(figures.profile, comparison=comparison)
        wanted.append(("profile", "Performance profile: time against the fastest", _HEIGHT, against))
    for number_of, measure in enumerate(figures.difficulties(comparison)):
        draw: Callable[[Canvas], None] = partial(figures.difficulty, comparison=comparison, measure=measure)
        wanted.append((f"difficulty-{number_of}", f"Success by difficulty: {measure}", _HEIGHT, draw))
    for name, title, height, draw in wanted:
        yield name, title, _svg(name, (_WIDTH, height), draw)


def _picture(
    index: int, found: Disagreement, comparison: Comparison, worlds: Mapping[str, RunHeader]
) -> tuple[str, Disagreement, str]:
    """Draw one disagreement; returns name, disagreement and SVG."""
    name, scenery = f"disagreement-{index}", worlds.get(found.winner.scene)

    def draw(canvas: Canvas) -> None:
        draw_disagreement(canvas, name, found, comparison, scenery)

    return name, found, _svg(name, picture_size(found), draw)


def _svg(name: str, size: tuple[float, float], draw: Callable[[Canvas], None]) -> str:
    return themed(name, render_canvas(name, lambda: make_canvas(size, draw), "svg").decode())


def _shown(found: Sequence[Disagreement]) -> list[Disagreement]:
    """Select the disagreements to draw: first one of each pair of planners, then a second one, and so on."""
    order: dict[tuple[str, str], int] = {}
    turns = []
    for each in found:
        pair = each.winner.planner, each.loser.planner
        order[pair] = order.get(pair, 0) + 1
        turns.append(order[pair])
    ranked = sorted(range(len(found)), key=lambda i: turns[i])
    return [found[i] for i in ranked[:PICTURES]]


def _short(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.{_DIGITS}g}")
