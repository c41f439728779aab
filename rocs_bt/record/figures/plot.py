"""Figures of activation and coordinates over time; writing of all figures to files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.errors import Fault, InputError, RecordingError
from ...base.files import write_whole
from ..history import History
from ..recording import Recording
from ..track import Span
from .arena import PLACES, Arena
from .commands import Commands
from .figure import INK, MUTED, OTHER, ROUTES, Figure, by_route, line_style, mark_worst, route_legend
from .height import HeightAndTilt

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


class Activation(Figure):
    """Activation over time: bars in one row for the route, one per fired rule and one per action."""

    name = "activation"
    title = "Activation over time"
    size = (7.2, 3.0)

    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        pairs = [(i, run, name) for i, run in enumerate(runs) for name in run.agents]
        if not pairs:
            return
        counts = [max(1, len(_rows(run, name))) for _, run, name in pairs]
        canvas.set_figheight(0.7 + 0.34 * sum(counts) + 0.3 * len(pairs))
        grid = canvas.subplots(len(pairs), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": counts})
        for axes, (i, run, name) in zip(grid[:, 0], pairs, strict=True):
            self._rows(axes, run, name, f"{self.name}-{i}-{name}")
            axes.set_title(f"{name} in {run.label}" if len(runs) > 1 else name)
            axes.set_xlim(run.header.start, max(*(r.end for r in runs), run.header.start + 0.1))
        grid[-1, 0].set_xlabel("t [s]")

    def _rows(self, axes: Axes, run: History, name: str, gid: str) -> None:
        rows = _rows(run, name)
        for y, (label, spans) in enumerate(rows.items()):
            bars = [(s.begin, max(s.end - s.begin, 0.02)) for s in spans]
            if label == "route":
                colors = [ROUTES.get(s.value, INK) for s in spans]
            else:
                colors = [ROUTES["reactive"] if label.startswith("rule ") else MUTED] * len(spans)
            drawn = axes.broken_barh(bars, (y - 0.32, 0.64), facecolors=colors, edgecolors="none")
            drawn.set_gid(f"{gid}-{y}")
        axes.set_yticks(range(len(rows)), list(rows))
        axes.set_ylim(len(rows) - 0.4, -0.6)
        axes.grid(axis="y", visible=False)
        axes.tick_params(axis="y", length=0)


def _rows(run: History, name: str) -> dict[str, list[Span]]:
    agent = run.agents[name]
    rows: dict[str, list[Span]] = {"route": agent.routes}
    for span in agent.reflexes():
        rows.setdefault(f"rule {span.value.rpartition('/')[2]}", []).append(span)
    for span in agent.runs():
        rows.setdefault(f"{span.value.action}()", []).append(span)
    return rows


class Coordinates(Figure):
    """Both coordinates over time, coloured by route; goals as thin lines, other robots black."""

    name = "coordinates"
    title = "Position over time"
    size = (7.2, 4.4)

    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        rows = canvas.subplots(2, 1, sharex=True)
        for i, (axes, what) in enumerate(zip(rows, "xy", strict=True)):
            for place in runs[0].header.places[:PLACES]:
                axes.axhline((place.x, place.y)[i], color=MUTED, lw=0.8, ls=":", gid=f"{self.name}-{what}-{place.name}")
            for r, run in enumerate(runs):
                for name, body in run.bodies.items():
                    gid = f"{self.name}-{r}-{what}-{name}"
                    if name not in run.agents:
                        style = {**line_style(r), "linewidth": 0.9}
                        axes.plot(body.t, body.pose[:, i], color=OTHER, gid=gid, **style)
                        continue
                    for k, (route, at) in enumerate(by_route(body, run.agents[name])):
                        color = ROUTES.get(route, INK)
                        axes.plot(body.t[at], body.pose[at, i], color=color, gid=f"{gid}-{k}", **line_style(r))
            axes.set_ylabel(f"{what} [m]")
            axes.margins(x=0.0)
            for name, agent in runs[0].agents.items():
                mark_worst(axes, agent, f"{self.name}-{what}-{name}", named=i == 0)
        rows[-1].set_xlabel("t [s]")
        columns = 5 + len(runs)
        route_legend(rows[0], runs, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderaxespad=0.1)


FIGURES: tuple[Figure, ...] = (Arena(), Coordinates(), HeightAndTilt(), Activation(), Commands())
_FORMATS = ("png", "svg", "pdf")


def write_figures(recordings: Sequence[Recording], folder: Path, formats: Sequence[str] = ("png", "svg")) -> list[Path]:
    """Write all figures of a run, or of several runs overlaid, to files.

    Args:
        recordings: One or more recordings; the world of the first is drawn.
        folder: Output folder; created if it does not exist.
        formats: Any of `png`, `svg`, `pdf`.

    Returns:
        Paths of the files.

    Raises:
        InputError: No recording, or an unknown format.
        RecordingError: A file cannot be written.
    """
    unknown = [f for f in formats if f not in _FORMATS]
    if unknown or not recordings:
        found = f"unknown format '{unknown[0]}'." if unknown else "there is no recording to plot."
        raise InputError(Fault(found, hint=f"Give one or more runs, and formats of: {', '.join(_FORMATS)}."))
    runs, paths = [History(r) for r in recordings], []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for figure in (figure for figure in FIGURES if figure.applies(runs)):
            for form in formats:
                paths.append(folder / f"{figure.name}.{form}")
                write_whole(paths[-1], figure.render(runs, form))
    except OSError as error:
        raise RecordingError(f"the figures cannot be written to '{folder}': {error.strerror}.") from error
    return paths
