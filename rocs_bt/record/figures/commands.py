"""Figure of motion commands and true motion: of wheels, or of the axes of a twist."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..history import BodyHistory, History, Series
from ..track import Curve
from .figure import INK, MUTED, Figure, line_style, shade_reflexes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

_AXES = {"vx": "forward [m/s]", "vy": "left [m/s]", "vz": "up [m/s]", "wz": "turn [rad/s]"}
_NAMES = {
    2: ("left", "right"),
    3: ("front left", "rear", "front right"),
    4: ("front left", "front right", "rear left", "rear right"),
}


class Commands(Figure):
    """Motion commands: one row per wheel, or per axis of a twist, with commands as steps and the true speed as a line.

    Reflexes are shaded.
    """

    name = "commands"
    title = "Motion commands"
    size = (7.2, 4.0)

    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        found = [(n, c) for n in runs[0].agents if (c := motion_command(runs[0], n)) is not None]
        axes_of = {info.name: info.axes for info in runs[0].header.agents}
        rows = [
            (name, i, label)
            for name, command in found
            for i, label in enumerate(_labels(axes_of.get(name, ()), command.width))
        ]
        if not rows:
            return
        canvas.set_figheight(0.9 + 1.45 * len(rows))
        grid = canvas.subplots(len(rows), 1, sharex=True, squeeze=False)
        for axes, (name, i, label) in zip(grid[:, 0], rows, strict=True):
            for r, run in enumerate(runs):
                self._row(axes, run, name, i, r, tag=f" {run.label}" if len(runs) > 1 else "")
            if name in runs[0].agents:
                shade_reflexes(axes, runs[0].agents[name])
            axes.set_ylabel(f"{name} {label}".replace(" [", "\n[") if len(found) > 1 else label)
            axes.margins(x=0.0)
        grid[0, 0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1)
        grid[-1, 0].set_xlabel("t [s]")

    def _row(self, axes: Axes, run: History, name: str, i: int, r: int, tag: str) -> None:
        gid = f"{self.name}-{r}-{name}-{i}"
        command = motion_command(run, name)
        if command is not None and i < command.width:
            style = {**line_style(r), "linewidth": 0.9}
            values = command.rows()[:, i]
            commanded = np.append(values, values[-1])
            times = np.append(command.t, run.end)
            axes.step(times, commanded, where="post", color=INK, label=f"commanded{tag}", gid=f"{gid}-command", **style)
        body, of = run.bodies.get(name), next((a.axes for a in run.header.agents if a.name == name), ())
        true = None if body is None else _true(body, of, i)
        if body is not None and true is not None:
            style = {**line_style(r), "linewidth": 2.2, "alpha": 0.6}
            axes.plot(body.t, true, color=MUTED, label=f"true{tag}", gid=f"{gid}-true", **style)


def _true(body: BodyHistory, axes: Sequence[str], i: int) -> Series | None:
    """True speed of wheel or axis `i` [m/s, rad/s]; None if unknown."""
    if i < body.wheels.shape[1]:
        return body.wheels[:, i]
    return body.speed(axes[i]) if i < len(axes) else None


def _labels(axes: Sequence[str], count: int) -> Sequence[str]:
    """Labels of the `count` values of a command: of the axes of a twist, else of wheels."""
    if len(axes) == count:
        return [_AXES[axis] for axis in axes]
    names = _NAMES[count] if count in _NAMES else [f"wheel {i + 1}" for i in range(count)]
    return [f"{name} [m/s]" for name in names]


def motion_command(run: History, agent: str) -> Curve | None:
    """Commands of the wheels' actuator: the first with as many values as the body has wheels, else the first of all.

    None if the agent has no commands.
    """
    commands = list(run.agents[agent].commands.values()) if agent in run.agents else []
    body = run.bodies.get(agent)
    fits = [c for c in commands if body is not None and c.width == body.wheels.shape[1]]
    return next(iter([*fits, *commands]), None)
