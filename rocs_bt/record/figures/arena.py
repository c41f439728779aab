"""Arena from above, with the paths coloured by route (paper, Figure 5b)."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.geometry import Pose2
from ..file.header import BodyInfo, Point, RunHeader
from ..fold.history import AgentHistory, History
from .figure import GRID, INK, MUTED, OTHER, PLACE, ROUTES, WALL, WORST, Figure, by_route, line_style, route_legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

LABEL_WIDTH = 22
"""Maximum number of characters in a line of the legend, beside which the arena needs its room."""

PLACES = 100
"""Maximum number of places that a figure draws with their names and sizes; the others are points."""


class Arena(Figure):
    """Arena from above: obstacles, goals and paths; dots mark atomic actions, squares switches of the route."""

    title = "The arena from above"
    size = (7.6, 5.4)  # a square arena and its legend

    def __init__(self, name: str = "arena") -> None:
        self.name = name

    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        from matplotlib.layout_engine import ConstrainedLayoutEngine

        bodies = {name for run in runs for name in run.bodies}
        self.draw_bodies(canvas.add_subplot(), runs, bodies, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        for _ in range(2):  # the layout of axes with a fixed aspect and a legend outside needs several passes
            ConstrainedLayoutEngine().execute(canvas)

    def draw_bodies(self, axes: Axes, runs: Sequence[History], bodies: Collection[str], **legend: Any) -> None:
        """Draw the world and the given bodies only; `legend` contains placement options of the legend."""
        from matplotlib.lines import Line2D

        axes.set_aspect("equal")
        draw_world(axes, runs[0].header, self.name)
        for i, run in enumerate(runs):
            for name in (name for name in run.bodies if name in bodies):
                if name in run.agents:
                    self._agent(axes, run, name, i)
                else:
                    self._other(axes, run, name, i)
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        marks = [
            Line2D([], [], color=MUTED, marker=".", markersize=4, linestyle="", label="atomic action"),
            Line2D(
                [],
                [],
                color=MUTED,
                marker="s",
                markersize=6,
                mfc="none",
                linestyle="",
                label="plan/reflex switch",
            ),
        ]
        route_legend(axes, runs, marks, bodies, LABEL_WIDTH, borderaxespad=0.0, **legend)

    def _agent(self, axes: Axes, run: History, name: str, i: int) -> None:
        body, agent = run.bodies[name], run.agents[name]
        gid = f"{self.name}-{i}-{name}"
        for k, (route, at) in enumerate(by_route(body, agent)):
            x, y = body.pose[at, 0], body.pose[at, 1]
            axes.plot(x, y, color=ROUTES.get(route, INK), gid=f"{gid}-path-{k}", zorder=3, **line_style(i))
        if not len(body.t):
            return
        for route, color in ROUTES.items():
            times = [a.t for a in agent.atomic if a.route == route]
            if times:
                dots = body.at(np.array(times))
                axes.plot(
                    *dots.T,
                    ".",
                    color=color,
                    ms=2.8,
                    alpha=line_style(i)["alpha"],
                    gid=f"{gid}-actions-{route}",
                    zorder=4,
                )
        self._switches(axes, run, name, gid)
        self._worst(axes, run, name, gid)
        axes.plot(*body.pose[0, :2], "o", color=INK, ms=5, mfc="none", gid=f"{gid}-start", zorder=6)
        draw_hull(axes, run, name, gid)

    def _switches(self, axes: Axes, run: History, name: str, gid: str) -> None:
        agent = run.agents[name]
        if agent.switches:
            at = run.bodies[name].at(np.array(agent.switches))
            colors = [_route_at(agent, t) for t in agent.switches]
            squares = axes.scatter(
                at[:, 0],
                at[:, 1],
                s=42,
                marker="s",
                facecolors="none",
                edgecolors=colors,
                linewidths=1.4,
                zorder=5,
            )
            squares.set_gid(f"{gid}-switches")

    def _worst(self, axes: Axes, run: History, name: str, gid: str) -> None:
        """Draw a cross at the robot's position at the minimum margin of each requirement."""
        for k, (requirement, t) in enumerate(run.agents[name].worst):
            (position,) = run.bodies[name].at(t)
            axes.plot(*position, "x", color=WORST, ms=8, mew=1.8, gid=f"{gid}-worst-{k}", zorder=6.5)
            style: dict[str, Any] = {"textcoords": "offset points", "color": WORST, "fontsize": 7.5, "zorder": 7}
            axes.annotate(requirement, position, (8, -8 - 9 * k), **style)

    def _other(self, axes: Axes, run: History, name: str, i: int) -> None:
        body = run.bodies[name]
        if not len(body.t):
            return
        gid = f"{self.name}-{i}-{name}"
        style = {**line_style(i), "linewidth": 1.0}
        axes.plot(body.pose[:, 0], body.pose[:, 1], color=OTHER, gid=f"{gid}-path", zorder=2, **style)
        draw_hull(axes, run, name, gid)


def draw_world(axes: Axes, header: RunHeader, gid: str) -> None:
    """Draw obstacles and places; `gid` is the prefix of the ids of the artists."""
    from matplotlib.patches import Circle, Polygon

    for i, ground in enumerate(header.grounds):
        patch = Polygon(ground.points, closed=True, fc="none", ec=MUTED, lw=0.8, ls="--", hatch="....", alpha=0.6)
        patch.set(gid=f"{gid}-ground-{i}", zorder=0.5)
        axes.add_patch(patch)
    for i, outline in enumerate(header.outlines):
        shape = (
            Circle(outline.points[0], outline.radius) if outline.radius > 0.0 else Polygon(outline.points, closed=True)
        )
        shape.set(facecolor=WALL, edgecolor=MUTED, linewidth=0.6, gid=f"{gid}-outline-{i}")
        axes.add_patch(shape)
    for i, place in enumerate(header.places[:PLACES]):
        radius = max(place.radius, 0.05)
        ring = Circle((place.x, place.y), radius, fill=False, ec=PLACE, lw=1.2, gid=f"{gid}-place-{i}")
        axes.add_patch(ring)
    if more := [(place.x, place.y) for place in header.places[PLACES:]]:
        axes.plot(*zip(*more, strict=True), ",", color=PLACE, gid=f"{gid}-places", rasterized=True)
    axes.margins(0.02)
    axes.autoscale_view()
    labels = _Labels(axes)
    for ground in header.grounds:
        corner = min(x for x, _ in ground.points), max(y for _, y in ground.points)
        high = f"{100.0 * ground.height:.3g} cm" if ground.height < 1.0 else f"{ground.height:.3g} m"  # as in arena.js
        labels.write(f"{ground.name}, {high}", corner, (4, -11), color=MUTED, fontsize=7.5)
    for place in (place for place in header.places[:PLACES] if place.known):
        labels.write(place.name, (place.x, place.y), (9, -19), color=PLACE, fontsize=9.0)


class _Labels:
    """Labels right of points, or left of them at the frame; a label is lower if it covers another one.

    Their sizes are estimated, because the layout is not known before the figure is complete.
    """

    def __init__(self, axes: Axes) -> None:
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        self._axes = axes
        self._scale = 330.0 / max(right - left, high - low)  # about that of the figure [points per metre]
        self._end = self._scale * right  # [points]
        self._boxes: list[tuple[float, float, float]] = []  # left, right, base line [points]

    def write(self, text: str, at: Point, offset: tuple[float, float], **style: Any) -> None:
        """Write a label at a point [m] with an offset [points]."""
        size, (along, down) = style["fontsize"], offset
        width = 0.55 * size * len(text)
        side = -1 if self._scale * at[0] + along + width > self._end else 1
        left = self._scale * at[0] + side * along - (width if side < 0 else 0.0)
        base = self._scale * at[1]
        while any(left < r and lo < left + width and abs(base + down - y) < size for lo, r, y in self._boxes):
            down -= size
        self._boxes.append((left, left + width, base + down))
        style |= {"ha": "left" if side > 0 else "right", "textcoords": "offset points", "annotation_clip": True}
        self._axes.annotate(text, at, (side * along, down), **style).set_in_layout(False)


def draw_hull(axes: Axes, run: History, name: str, gid: str, *, at: int = -1, color: str = GRID) -> None:
    """Draw a body's outline, heading and name at one of its samples, the last by default."""
    from matplotlib.patches import Polygon

    infos = [b for b in run.header.bodies if b.name == name and b.hull]
    if infos:
        pose = Pose2(*run.bodies[name].pose[at].tolist())
        shape = Polygon(_placed(infos[0], pose), closed=True, fc=color, ec=INK, lw=0.9, alpha=0.8, zorder=2.5)
        shape.set_gid(f"{gid}-hull")
        axes.add_patch(shape)
        nose = max(x for x, _ in infos[0].hull)
        axes.plot(*zip(pose[:2], pose.transform(nose, 0.0), strict=True), color=INK, lw=0.9, zorder=2.6)
        peak = max(_placed(infos[0], pose), key=lambda point: point[1])
        ha = "right" if peak[0] > 0.5 * sum(axes.get_xlim()) else "left"  # away from the frame
        label = axes.annotate(name, peak, (0, 2), textcoords="offset points", color=INK, weight="bold", ha=ha, zorder=7)
        label.set_in_layout(False)


def _placed(info: BodyInfo, pose: Pose2) -> list[tuple[float, float]]:
    return [pose.transform(x, y) for x, y in info.hull]


def _route_at(agent: AgentHistory, t: float) -> str:
    names = [s.value for s in agent.routes if math.isclose(s.begin, t)]
    return ROUTES.get(names[0], INK) if names else INK
