"""Base class of figures, colours, and drawing without pyplot and its global state."""

from __future__ import annotations

import io
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...base.errors import RecordingError
from ...base.files import write_whole
from ..fold.history import AgentHistory, BodyHistory, History

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

# Colours of the paper's Figure 5b: deliberative red, reactive blue, the disturbing robot black.
INK, MUTED, GRID, WALL, PLACE, OTHER = "#1d2733", "#66717f", "#dde2e8", "#c3cad3", "#1d8a4e", "#12161b"
WORST = "#a8610a"
ROBOTS = ("#7b3fb5", "#c26a00", "#0f7a72")
"""Colours of agents in figures that do not show routes."""
ROUTES = {"deliberative": "#c9302c", "reactive": "#1c62c4", "idle": "#98a2ae"}
_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",  # keep text as text: small, searchable, in the reader's font
    "font.family": "sans-serif",
    "font.size": 9.0,
    "text.parse_math": False,  # names of places and rules may contain dollar signs
    "text.color": INK,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
}


class Figure(ABC):
    """Figure of one run, or of several runs overlaid.

    Attributes:
        name: File stem, and prefix of the ids of the artists.
        title: Short title.
        size: Width and height [inch].
    """

    name: str
    title: str
    size: tuple[float, float] = (7.2, 4.2)

    @abstractmethod
    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        """Draw the runs on a canvas: the first with solid lines, the others fainter and dashed."""

    def applies(self, runs: Sequence[History]) -> bool:
        """Whether the runs contain what the figure shows."""
        return True

    def make(self, runs: Sequence[History]) -> Canvas:
        """Draw the runs on a new canvas."""
        return make_canvas(self.size, lambda canvas: self.draw(canvas, runs))

    def render(self, runs: Sequence[History], form: str) -> bytes:
        """Render the figure as a `png`, `svg` or `pdf` file; equal runs give equal bytes."""
        return render_canvas(self.name, lambda: self.make(runs), form)


def make_canvas(size: tuple[float, float], draw: Callable[[Canvas], None]) -> Canvas:
    """Make a canvas of a size [inch] in the style of rocs_bt and draw on it."""
    import matplotlib
    from matplotlib.figure import Figure as Canvas

    with matplotlib.rc_context(_STYLE):
        canvas = Canvas(figsize=size, layout="constrained")
        draw(canvas)
    return canvas


def render_canvas(name: str, make: Callable[[], Canvas], form: str) -> bytes:
    """Render a canvas as a `png`, `svg` or `pdf` file; equal drawings give equal bytes."""
    import matplotlib

    undated: dict[str, Any] = {"svg": {"Date": None, "Creator": None}, "pdf": {"CreationDate": None}}
    buffer = io.BytesIO()
    # The salt determines the ids in an SVG; one per figure keeps ids unique on a page with several figures.
    with matplotlib.rc_context({**_STYLE, "svg.hashsalt": name}):
        face = "none" if form == "svg" else "white"
        make().savefig(buffer, format=form, dpi=160, metadata=undated.get(form, {"Software": None}), facecolor=face)
    return buffer.getvalue()


def write_files(drawings: Mapping[Path, Callable[[], bytes]]) -> list[Path]:
    """Write drawings to files of one folder, which is created if it does not exist; returns the files.

    Raises:
        RecordingError: A file cannot be written.
    """
    for path, render in drawings.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, render())
        except OSError as error:
            raise RecordingError(f"the figures cannot be written to '{path.parent}': {error.strerror}.") from error
    return list(drawings)


def line_style(run: int) -> dict[str, Any]:
    """Line style of the first run (0) and of the runs overlaid on it."""
    return {"linestyle": "-", "alpha": 1.0} if run == 0 else {"linestyle": (0, (4, 2)), "alpha": 0.65}


def by_route(body: BodyHistory, agent: AgentHistory) -> Iterator[tuple[str, NDArray[np.intp]]]:
    """Segments of a body's path, each with its route and the indices of its samples; neighbours share an end."""
    for span in agent.routes:
        indices = np.flatnonzero((body.t >= span.begin - 1e-9) & (body.t <= span.end + 1e-9))
        if len(indices) > 1:
            yield span.value, indices


def shade_reflexes(axes: Axes, agent: AgentHistory) -> None:
    """Shade the time intervals in which reflexes controlled the robot (reactive route)."""
    for span in agent.routes:
        if span.value == "reactive":
            axes.axvspan(span.begin, span.end, color=ROUTES["reactive"], alpha=0.12, linewidth=0)


def mark_worst(axes: Axes, agent: AgentHistory, gid: str, *, named: bool) -> None:
    """Draw a line at the time of the minimum margin of each requirement."""
    for k, (name, t) in enumerate(agent.worst):
        axes.axvline(t, color=WORST, lw=1.0, ls=(0, (1, 1.5)), gid=f"{gid}-worst-{k}")
        if named:
            left = t > 0.5 * sum(axes.get_xlim())
            axes.annotate(
                name,
                (t, 1.0),
                (-3 if left else 3, -2 - 9 * k),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                color=WORST,
                ha="right" if left else "left",
                va="top",
                fontsize=7.5,
            )


def route_legend(
    axes: Axes,
    runs: Sequence[History],
    extra: Sequence[Any] = (),
    bodies: Collection[str] | None = None,
    width: int = 200,
    **place: Any,
) -> None:
    """Draw the legend: routes, bodies without an agent, and line styles of several runs."""
    from matplotlib.lines import Line2D

    agents = [a for run in runs for name, a in run.agents.items() if bodies is None or name in bodies]
    routes = {span.value for agent in agents for span in agent.routes}
    handles: list[Any] = [Line2D([], [], color=c, label=name) for name, c in ROUTES.items() if name in routes]
    handles += extra
    others = [n for n in runs[0].bodies if n not in runs[0].agents and (bodies is None or n in bodies)]
    if others:
        handles.append(Line2D([], [], color=OTHER, lw=1.0, label=fill(", ".join(others), width)))
    if len(runs) > 1:
        handles += [Line2D([], [], color=MUTED, label=run.label, **line_style(i)) for i, run in enumerate(runs)]
    axes.legend(handles=handles, **place)
