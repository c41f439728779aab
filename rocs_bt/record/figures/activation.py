"""What was active when: the route, the reflexes and the actions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..history import History, Span
from .figure import INK, MUTED, ROUTES, Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


class Activation(Figure):
    """A row for the route, one for each rule that fired, one for each action that ran; bars where it was active."""

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
                colors = [ROUTES.get(s.name, INK) for s in spans]
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
    for reflex in agent.reflexes(run.end):
        rows.setdefault(f"rule {reflex.name.rpartition('/')[2]}", []).append(reflex)
    for span in agent.runs(run.end):
        rows.setdefault(f"{span.name.partition(' #')[0]}()", []).append(span)
    return rows
