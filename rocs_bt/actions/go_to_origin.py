"""GoToOrigin = TurnToPosition; SetWheelSpeed (paper, Table 2)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar

from ..base.geometry import Pose2, Twist2
from ..base.units import PositiveMetres, PositiveMetresPerSecond, PositiveRadians
from ..interfaces.action import Action, Body, MacroAction
from .pose import PoseWatch
from .set_twist import hold_twist
from .stop import Stop
from .turn import TurnToPosition

if TYPE_CHECKING:
    from ..knowledge import Knowledge

ORIGIN = "origin"
_POSE = Pose2(0.0, 0.0)


class GoToOrigin(MacroAction):
    """Turn toward the origin of the world frame and drive straight; turn again when the bearing error grows.

    As in the paper: constant wheel speeds between the turns, no follower. The action adds the goal node `origin` to the
    world model if it is missing, and pursues it.

    Attributes:
        speed: Speed of the straight drive [m/s].
        tolerance: Distance from the origin at which it is reached [m].
        drift: Bearing error that triggers another turn [rad].
    """

    speed: PositiveMetresPerSecond = 0.3
    tolerance: PositiveMetres = 0.08
    drift: PositiveRadians = 0.2
    goal: ClassVar[str] = ORIGIN

    def decompose(self, body: Body) -> Iterator[Action]:
        world, watch = body.knowledge.world, PoseWatch()
        if ORIGIN not in world.goals():
            world.place(ORIGIN, _POSE, kind="goal")
        world.pursue(ORIGIN)
        while (pose := watch.read(body)) is None or pose.distance(_POSE) > self.tolerance:
            yield TurnToPosition(x=0.0, y=0.0)
            yield hold_twist(body, Twist2(self.speed), until=self._stops)
        world.pursue(None)
        yield Stop()

    def remaining(self, knowledge: Knowledge) -> float:
        return knowledge.robot.pose().distance(_POSE)

    def _stops(self, body: Body) -> bool:
        """Whether to end the straight drive: arrived, bearing error too large, or pose lost."""
        pose = body.knowledge.robot.pose(body.clock.now())
        if not all(map(math.isfinite, pose)):
            return True
        return pose.distance(_POSE) <= self.tolerance or abs(pose.bearing(_POSE)) > self.drift
