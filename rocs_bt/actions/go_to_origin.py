"""GoToOrigin = TurnToPosition; SetWheelSpeed (paper, Table 2)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from ..action import Action, Body, MacroAction
from ..geometry import Pose2, Twist2
from ..units import PositiveMetres, PositiveMetresPerSecond, PositiveRadians
from .pose import PoseWatch
from .set_wheel_speed import SetWheelSpeed
from .stop import Stop
from .turn import TurnToPosition

if TYPE_CHECKING:
    from ..knowledge import Knowledge

ORIGIN = "origin"
_PLACE = Pose2(0.0, 0.0)


@dataclass(kw_only=True, eq=False)
class GoToOrigin(MacroAction):
    """Look at the world frame's origin and drive at it, and again when the robot has drifted off the line.

    The paper's way, without the follower: constant wheel speeds in between. The goal node `origin` is put into the
    world model where it is missing, and pursued.

    Attributes:
        speed: How fast [m/s].
        tolerance: Distance from the origin at which it is reached [m].
        drift: Bearing error at which to look at the origin anew [rad].
    """

    speed: PositiveMetresPerSecond = 0.3
    tolerance: PositiveMetres = 0.08
    drift: PositiveRadians = 0.2
    goal: ClassVar[str] = ORIGIN

    def decompose(self, body: Body) -> Iterator[Action]:
        world, watch = body.knowledge.world, PoseWatch()
        if ORIGIN not in world.goals():
            world.place(ORIGIN, _PLACE, kind="goal")
        world.pursue(ORIGIN)
        while (pose := watch.look(body)) is None or pose.distance(_PLACE) > self.tolerance:
            yield TurnToPosition(x=0.0, y=0.0)
            yield SetWheelSpeed(speeds=body.drive.wheel_speeds(Twist2(self.speed)).tolist(), until=self._look_up)
        world.pursue(None)
        yield Stop()

    def remaining(self, knowledge: Knowledge) -> float:
        return knowledge.robot.pose().distance(_PLACE)

    def _look_up(self, body: Body) -> bool:
        """Whether to stop driving: there, off the line, or without a pose."""
        pose = body.knowledge.robot.pose(body.clock.now())
        if not all(map(math.isfinite, pose)):
            return True
        return pose.distance(_PLACE) <= self.tolerance or abs(pose.bearing(_PLACE)) > self.drift
