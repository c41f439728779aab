"""Counterparts of the paper's Figures 5b, 7b, 8 and 9a to 9e."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rocs_bt.base.geometry import Pose2
from rocs_bt.record.figures.arena import Arena, draw_hull, draw_world
from rocs_bt.record.figures.figure import MUTED, OTHER, ROBOTS, ROUTES, Figure
from rocs_bt.record.file.header import Beam
from rocs_bt.record.fold.history import AgentHistory, History
from rocs_bt.record.fold.track import Span

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

_ABOVE: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.01), "ncols": 3}


class Trajectory(Figure):
    """One robot's path by route, with a dot per action and a square per switch; below, a timeline of the pipeline.

    Args:
        name: Name of the file.
        title: Title.
        agent: Name of the robot.
        others: Whether to draw scripted robots too.
    """

    size = (5.2, 6.6)

    def __init__(self, name: str, title: str, agent: str, *, others: bool = True) -> None:
        self.name = name
        self.title = title
        self._agent = agent
        self._others = others
        self._arena = Arena(name)

    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        run = runs[0]
        rows = enqueued(run.agents[self._agent])
        height = 0.3 + 0.2 * (len(rows) + 1)
        canvas.set_figheight(5.3 + height)
        above, below = canvas.subplots(2, 1, gridspec_kw={"height_ratios": [5.0, height]})
        bodies = [b for b in run.bodies if b == self._agent or (self._others and b not in run.agents)]
        self._arena.draw_bodies(above, runs[:1], bodies, **_ABOVE)
        self._timeline(below, run, rows)

    def _timeline(self, axes: Axes, run: History, rows: Mapping[str, Sequence[Span]]) -> None:
        spans = [span for span in run.agents[self._agent].routes if span.value in ROUTES]
        bars = [(s.begin, s.end - s.begin) for s in spans]
        drawn = axes.broken_barh(bars, (-0.36, 0.72), facecolors=[ROUTES[s.value] for s in spans])
        drawn.set_gid(f"{self.name}-route")
        for y, (name, queue) in enumerate(rows.items(), 1):
            color = ROUTES["reactive" if queue[0].value.priority.startswith("HIGH") else "deliberative"]
            bars = [(s.begin, max(s.end - s.begin, 0.02)) for s in queue]
            axes.broken_barh(bars, (y - 0.3, 0.6), facecolors=color, alpha=0.3, gid=f"{self.name}-{name}")
            axes.plot(
                [s.begin for s in queue], [y] * len(queue), "|", color=color, ms=7, gid=f"{self.name}-{name}-began"
            )
        axes.set_yticks(range(len(rows) + 1), ["route", *rows])
        axes.set_ylim(len(rows) + 0.5, -0.6)
        axes.set_xlim(run.header.start, max(run.end, run.header.start + 0.1))
        axes.set_xlabel("t [s]")
        axes.grid(axis="y", visible=False)
        axes.tick_params(axis="y", length=0)


class Paths(Figure):
    """Paths of all robots with an agent, one colour each (Figure 9a)."""

    size = (5.2, 5.4)

    def __init__(self, name: str, title: str) -> None:
        self.name = name
        self.title = title

    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        run, axes = runs[0], canvas.add_subplot()
        axes.set_aspect("equal")
        draw_world(axes, run.header, self.name)
        for color, name in zip(ROBOTS, run.agents, strict=False):
            pose = run.bodies[name].pose
            axes.plot(pose[:, 0], pose[:, 1], color=color, label=name, gid=f"{self.name}-{name}", zorder=3)
            axes.plot(*pose[0, :2], "o", color=color, ms=5, mfc="none", gid=f"{self.name}-{name}-start", zorder=4)
            draw_hull(axes, run, name, f"{self.name}-{name}")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.legend(**_ABOVE, borderaxespad=0.0)


class Axis(Figure):
    """One coordinate of all robots with an agent over time, one colour each (Figures 9b and 9c).

    Args:
        name: Name of the file.
        title: Title.
        which: 0 for x, 1 for y.
    """

    size = (6.4, 2.9)

    def __init__(self, name: str, title: str, which: int) -> None:
        self.name = name
        self.title = title
        self._which = which

    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        run, axes = runs[0], canvas.add_subplot()
        goals = {(place.x, place.y)[self._which] for place in run.header.places}
        for i, goal in enumerate(sorted(goals)):
            axes.axhline(goal, color=MUTED, lw=0.8, ls=":", gid=f"{self.name}-goal-{i}")
        for color, name in zip(ROBOTS, run.agents, strict=False):
            body = run.bodies[name]
            axes.plot(body.t, body.pose[:, self._which], color=color, label=name, gid=f"{self.name}-{name}")
        axes.set_xlabel("t [s]")
        axes.set_ylabel(f"{'xy'[self._which]} [m]")
        axes.margins(x=0.0)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(run.agents), borderaxespad=0.1)


class Scene(Figure):
    """Start positions, and the cones of the range sensors (Figure 8)."""

    size = (5.2, 5.4)

    def __init__(self, name: str, title: str) -> None:
        self.name = name
        self.title = title

    def draw(self, canvas: Canvas, runs: Sequence[History]) -> None:
        run, axes = runs[0], canvas.add_subplot()
        axes.set_aspect("equal")
        draw_world(axes, run.header, self.name)
        colors = dict(zip(run.agents, ROBOTS, strict=False))
        for info in run.header.bodies:
            if not len(run.bodies[info.name].t):
                continue
            pose, color = Pose2(*run.bodies[info.name].pose[0].tolist()), colors.get(info.name, OTHER)
            for name, beams in info.beams.items():
                for i, beam in enumerate(beams):
                    self._beam(axes, pose, beam, color, f"{self.name}-{info.name}-{name}-{i}")
            draw_hull(axes, run, info.name, f"{self.name}-{info.name}", at=0, color=color)
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.legend(handles=self._legend(run, colors), **_ABOVE, borderaxespad=0.0)

    def _beam(self, axes: Axes, pose: Pose2, beam: Beam, color: str, gid: str) -> None:
        from matplotlib.patches import Wedge

        at, direction = pose.transform(beam.x, beam.y), math.degrees(pose.yaw + beam.yaw)
        half = max(math.degrees(beam.cone) / 2.0, 0.3)
        axes.add_patch(
            Wedge(
                at, beam.reach, direction - half, direction + half, fc=color, ec="none", alpha=0.09, gid=gid, zorder=2
            )
        )

    def _legend(self, run: History, colors: Mapping[str, str]) -> list[Any]:
        from matplotlib.patches import Patch

        labels = {a.name: f"{a.name}: {a.mission}" for a in run.header.agents}
        rows = [(labels.get(b.name, f"{b.name}: scripted"), colors.get(b.name, OTHER)) for b in run.header.bodies]
        return [Patch(fc=color, alpha=0.6, label=label) for label, color in rows]


def enqueued(agent: AgentHistory) -> dict[str, list[Span]]:
    """Time spans of the pipeline's tickets, by action name."""
    rows: dict[str, list[Span]] = {}
    for span in agent.runs():
        rows.setdefault(span.value.action, []).append(span)
    return rows
