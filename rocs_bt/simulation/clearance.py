"""How near each agent came to anything, measured no more often than it can have come nearer."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ..drivers.mujoco import MujocoWorld
from ..drivers.mujoco.nearness import Among
from ..event import Approached, EventSink
from ..geometry import Pose2, wrap_angle

AMONG: tuple[Among, ...] = ("obstacles", "robots")


class ClearanceWatch:
    """Tells each time that an agent's hull is nearer to something than ever before.

    A hull comes nearer to what stands still by no more than its robot has moved, and to another robot by no more than
    the two have. No point of a hull moves farther than its axle does and its turn carries it. So a measured distance,
    less what has been moved since, is one that nothing can be nearer than: it is measured anew when that is no more
    than the least distance so far.

    Args:
        world: Where the robots are.
        agents: Whose hulls to watch.
        sink: Where Approached events go.
    """

    def __init__(self, world: MujocoWorld, agents: Iterable[str], sink: EventSink) -> None:
        self._world = world
        self._sink = sink
        self._nearest = dict.fromkeys(agents, math.inf)
        self._sure = {name: dict.fromkeys(AMONG, -math.inf) for name in self._nearest}  # [m] nothing is nearer
        self._poses: dict[str, Pose2] = {}

    def look(self, t: float) -> None:
        """Measure whose turn it is, at time t [s]."""
        moved = {name: self._moved(name) for name in self._world.robots}
        *_, second, most = sorted([0.0, *moved.values()])
        carried = not self._world.only_robots_move
        for name, sure in self._sure.items():
            own = moved[name]
            sure["obstacles"] -= math.inf if carried else own
            sure["robots"] -= own + (second if own == most else most)
            due = [among for among in AMONG if sure[among] <= self._nearest[name]]
            if due:
                self._measure(t, name, due)

    def _moved(self, name: str) -> float:
        """How far any point of a robot's hull can have moved since the last look [m]."""
        pose, reach = self._world.pose(name), self._world.robots[name].reach
        before, self._poses[name] = self._poses.get(name, pose), pose
        return pose.distance(before) + reach * abs(wrap_angle(pose.yaw - before.yaw))

    def _measure(self, t: float, name: str, due: Iterable[Among]) -> None:
        found = {among: self._world.clearance(name, among=among) for among in due}
        for among, (distance, _) in found.items():
            self._sure[name][among] = distance
        distance, other = min(found.values(), key=lambda near: near[0])
        if distance < self._nearest[name]:
            self._nearest[name] = distance
            self._sink.emit(Approached(t=t, agent=name, other=other, distance=distance))
