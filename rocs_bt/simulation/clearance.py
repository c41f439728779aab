"""How near each agent came to anything, measured no more often than it can have come nearer."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ..drivers.mujoco import MujocoWorld
from ..event import Approached, EventSink
from ..geometry import Pose2, wrap_angle


class ClearanceWatch:
    """Tells each time that an agent's hull is nearer to something than ever before.

    Hulls come nearer by no more than all robots have moved, and no point of a hull moves farther than its axle does and
    its turn carries it. So a measured distance holds good until that sum is what it exceeds the least distance by.

    Args:
        world: Where the robots are.
        agents: Whose hulls to watch.
        sink: Where Approached events go.
    """

    def __init__(self, world: MujocoWorld, agents: Iterable[str], sink: EventSink) -> None:
        self._world = world
        self._sink = sink
        self._nearest = dict.fromkeys(agents, math.inf)
        self._spare = dict.fromkeys(self._nearest, 0.0)  # [m] that may be moved before the next measurement
        self._poses: dict[str, Pose2] = {}

    def look(self, t: float) -> None:
        """Measure whose turn it is, at time t [s]."""
        moved = sum(map(self._moved, self._world.robots)) if self._world.only_robots_move else math.inf
        for name in self._nearest:
            self._spare[name] -= moved
            if self._spare[name] <= 0.0:
                self._measure(t, name)

    def _moved(self, name: str) -> float:
        """How far any point of a robot's hull can have moved since the last look [m]."""
        pose, reach = self._world.pose(name), self._world.robots[name].reach
        before, self._poses[name] = self._poses.get(name, pose), pose
        return pose.distance(before) + reach * abs(wrap_angle(pose.yaw - before.yaw))

    def _measure(self, t: float, name: str) -> None:
        distance, other = self._world.clearance(name)
        if distance < self._nearest[name]:
            self._nearest[name] = distance
            self._sink.emit(Approached(t=t, agent=name, other=other, distance=distance))
        self._spare[name] = distance - self._nearest[name]
