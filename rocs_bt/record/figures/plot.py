"""Figures of activation and coordinates over time; writing of all figures to files."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.errors import Fault, InputError
from ..file.recording import Recording
from ..fold.history import BodyHistory, History, Series
from ..fold.track import Curve, Span
from .arena import PLACES, Arena
from .figure import (
    INK,
    MUTED,
    OTHER,
    ROBOTS,
    ROUTES,
    WORST,
    Figure,
    by_route,
    line_style,
    mark_worst,
    route_legend,
    shade_reflexes,
    write_files,
)

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
    runs = [History(recording) for recording in recordings]
    figures = [figure for figure in FIGURES if figure.applies(runs)]
    return write_files(
        {folder / f"{f.name}.{form}": partial(f.render, runs, form) for f in figures for form in formats}
    )
