"""AvoidCollision = TurnAngle; SetWheelSpeed (paper, Table 2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..action import Action, Body, MacroAction
from ..geometry import Twist2
from ..units import MetresPerSecond, PositiveRadiansPerSecond, PositiveSeconds, Radians
from .set_wheel_speed import SetWheelSpeed
from .turn_angle import TurnAngle


@dataclass(kw_only=True, eq=False)
class AvoidCollision(MacroAction):
    """Turn away, then drive straight on for a while. It looks at no sensor: the rule that asked for it does.

    Attributes:
        turn: How far to turn, left positive [rad].
        duration: How long to drive on [s].
        speed: How fast to drive on [m/s].
        rate: How fast to turn [rad/s].
    """

    turn: Radians
    duration: PositiveSeconds = 2.0
    speed: MetresPerSecond = 0.25
    rate: PositiveRadiansPerSecond = 1.5

    def decompose(self, body: Body) -> Iterator[Action]:
        yield TurnAngle(angle=self.turn, rate=self.rate)
        yield SetWheelSpeed(speeds=body.drive.wheel_speeds(Twist2(self.speed)).tolist(), duration=self.duration)
