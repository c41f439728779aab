"""Minimum clearance of each agent, measured only when it can have decreased."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable

from ..base.geometry import Pose2, Pose3, wrap_angle
from ..devices.mujoco import MujocoWorld
from ..devices.mujoco.nearness import Among
from ..event import EventSink, MinClearanceLowered

AMONG: tuple[Among, ...] = ("obstacles", "robots")


class ClearanceWatch:
    """Emits an MinClearanceLowered event whenever the clearance of an agent's hull reaches a new minimum.

    Measuring is slow, so a lower bound of the clearance is kept. The clearance to a static obstacle decreases at most
    by the displacement of the robot, the clearance to another robot at most by the displacements of both robots. A
    point of the hull moves at most by the displacement of the base plus hull radius times turn. Robots without wheels
    are displaced in space, and turn about three axes. The last measured
    clearance minus these displacements is a lower bound. The clearance is measured again only when the bound does not
    exceed the minimum so far.
    """

    def __init__(
        self, world: MujocoWorld, agents: Iterable[str], sink: EventSink, spatial: Collection[str] = ()
    ) -> None:
        self._world = world
        self._sink = sink
        self._nearest = dict.fromkeys(agents, math.inf)
        self._bound = {name: dict.fromkeys(AMONG, -math.inf) for name in self._nearest}  # [m] lower bounds
        self._poses: dict[str, Pose2] = {}
        self._spatial = spatial
        self._in_space: dict[str, Pose3] = {}

    def update(self, t: float) -> None:
        """Measure, at time t [s], the clearances with lower bounds that require it."""
        moved = {name: self._moved(name) for name in self._world.robots}
        *_, second, most = sorted([0.0, *moved.values()])
        moving_obstacles = not self._world.only_robots_move
        for name, bound in self._bound.items():
            own = moved[name]
            bound["obstacles"] -= math.inf if moving_obstacles else own
            bound["robots"] -= own + (second if own == most else most)
            due = [among for among in AMONG if bound[among] <= self._nearest[name]]
            if due:
                self._measure(t, name, due)

    def _moved(self, name: str) -> float:
        """Maximum displacement of a point of a robot's hull since the last update [m]."""
        if name in self._spatial:
            return self._moved_in_space(name)
        pose, reach = self._world.pose(name), self._world.robots[name].reach
        before, self._poses[name] = self._poses.get(name, pose), pose
        return pose.distance(before) + reach * abs(wrap_angle(pose.yaw - before.yaw))

    def _moved_in_space(self, name: str) -> float:
        pose, reach = self._world.pose3(name), self._world.robots[name].reach
        before, self._in_space[name] = self._in_space.get(name, pose), pose
        turned = sum(abs(wrap_angle(a - b)) for a, b in zip(pose[3:], before[3:], strict=True))
        return math.dist(pose[:3], before[:3]) + reach * turned

    def _measure(self, t: float, name: str, due: Iterable[Among]) -> None:
        found = {among: self._world.clearance(name, among=among) for among in due}
        for among, (distance, _) in found.items():
            self._bound[name][among] = distance
        distance, other = min(found.values(), key=lambda near: near[0])
        if distance < self._nearest[name]:
            self._nearest[name] = distance
            self._sink.emit(MinClearanceLowered(t=t, agent=name, other=other, distance=distance))
