"""AvoidCollision = TurnAngle; SetWheelSpeed (paper, Table 2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..action import Action, Body, MacroAction
from ..geometry import Twist2
from ..units import MetresPerSecond, PositiveRadiansPerSecond, PositiveSeconds, Radians
from .room import free_turn, room_back
from .set_wheel_speed import SetWheelSpeed
from .turn import TurnAngle

BACK = 0.3  # [m] that it backs off at most
BACKING = 0.35  # [m/s] at which it does
LEFT = 0.1  # of a turn: while it is closed in on, the obstacle comes nearer


@dataclass(kw_only=True, eq=False)
class AvoidCollision(MacroAction):
    """Turn away, then drive straight on for a while. What is ahead is the matter of the rule that asked for it.

    It drives on while the last tenth of the turn is left, and the wheels still turn.

    What a corner of the hull would sweep is its own: on a robot whose monitor tells `free_turn` it turns no farther,
    and where that is less than half of what was asked for, it first backs off over ground that it knows to be free.

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
        if abs(free_turn(body, self.turn)) < 0.5 * abs(self.turn) and (back := min(room_back(body), BACK)) > 0.0:
            yield _straight(body, -BACKING, back / BACKING)
        turn = free_turn(body, self.turn)
        yield TurnAngle(angle=turn, rate=self.rate, tolerance=max(LEFT * abs(turn), TurnAngle.tolerance))
        yield _straight(body, self.speed, self.duration)


def _straight(body: Body, speed: float, duration: float) -> SetWheelSpeed:
    return SetWheelSpeed(speeds=body.drive.wheel_speeds(Twist2(speed)).tolist(), duration=duration)
