"""Figure of height and tilt over time, for robots without wheels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..history import History
from .figure import MUTED, OTHER, ROBOTS, WORST, Figure, line_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


class HeightAndTilt(Figure):
    """Height of the base and angle from the vertical over time; pushes are dotted lines."""

    name = "height"
    title = "Height and tilt over time"
    size = (7.2, 3.6)

    def applies(self, runs: Sequence[History]) -> bool:
        return any(body.spatial for run in runs for body in run.bodies.values())

    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        if not self.applies(runs):
            return
        height, tilt = rows = canvas.subplots(2, 1, sharex=True)
        for r, run in enumerate(runs):
            of_agents = dict(zip(run.agents, ROBOTS * len(run.agents), strict=False))
            for name, body in run.bodies.items():
                if not body.spatial:
                    continue
                style = {"color": of_agents.get(name, OTHER), **line_style(r)}
                label = f"{name} in {run.label}" if len(runs) > 1 else name
                height.plot(body.t, body.height, label=label, gid=f"{self.name}-{r}-{name}-height", **style)
                tilt.plot(body.t, np.degrees(body.tilt), gid=f"{self.name}-{r}-{name}-tilt", **style)
            _pushes(rows, run, f"{self.name}-{r}")
        height.axhline(0.0, color=MUTED, lw=0.8)
        height.set_ylabel("height [m]")
        tilt.set_ylabel("tilt [deg]")
        tilt.set_ylim(bottom=0.0)
        for axes in rows:
            axes.margins(x=0.0)
        tilt.set_xlabel("t [s]")
        height.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1)


def _pushes(rows: Sequence[Axes], run: History, gid: str) -> None:
    for k, push in enumerate(run.pushes):
        for i, axes in enumerate(rows):
            axes.axvline(push.t, color=WORST, lw=1.0, ls=(0, (1, 1.5)), gid=f"{gid}-{push.body}-push-{k}-{i}")
        words: dict[str, Any] = {"textcoords": "offset points", "color": WORST, "fontsize": 7.5, "va": "top"}
        label = "push" if len(run.bodies) == 1 else f"push of {push.body}"
        rows[0].annotate(label, (push.t, 1.0), (3, -2), xycoords=("data", "axes fraction"), **words)
