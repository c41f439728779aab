"""x(t) and y(t) of every body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..history import History
from .figure import INK, MUTED, OTHER, ROUTES, Figure, by_route, line_style, mark_worst, route_legend

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


class Coordinates(Figure):
    """Both coordinates over time, coloured by route; goals as thin lines, others in black."""

    name = "coordinates"
    title = "Position over time"
    size = (7.2, 4.4)

    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        rows = canvas.subplots(2, 1, sharex=True)
        for i, (axes, what) in enumerate(zip(rows, "xy", strict=True)):
            for place in runs[0].header.places:
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
