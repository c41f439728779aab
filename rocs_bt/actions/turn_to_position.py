"""TurnToPosition: look at a place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..action import Action, Body, MacroAction
from ..geometry import Pose2
from ..units import Metres, PositiveRadiansPerSecond
from .pose import PoseWatch
from .stop import Stop
from .turn_angle import TurnAngle


@dataclass(kw_only=True, eq=False)
class TurnToPosition(MacroAction):
    """Turn on the spot until the robot looks at a position: a TurnAngle whose angle is known when it begins.

    Attributes:
        x: In the world frame [m].
        y: In the world frame [m].
        rate: Fastest turn [rad/s].
    """

    x: Metres
    y: Metres
    rate: PositiveRadiansPerSecond = 1.5

    def decompose(self, body: Body) -> Iterator[Action]:
        watch = PoseWatch()
        while (pose := watch.look(body)) is None:
            yield Stop(patience=body.period)
        yield TurnAngle(angle=pose.bearing(Pose2(self.x, self.y)), rate=self.rate)
