"""AvoidCollision = TurnAngle; SetWheelSpeed (paper, Table 2)."""

from __future__ import annotations

from collections.abc import Iterator

from ..base.geometry import Twist2
from ..base.units import MetresPerSecond, PositiveRadiansPerSecond, PositiveSeconds, Radians
from ..interfaces.action import Action, Body, MacroAction
from .room import free_turn, room_back
from .set_twist import hold_twist
from .turn import TurnAngle

BACK = 0.3  # [m] maximum distance of backing off
BACKING = 0.35  # [m/s] speed of backing off
LEFT = 0.1  # share of the turn that may be left when the robot drives on; an exact turn would cost time


class AvoidCollision(MacroAction):
    """Turn away, then drive straight for a time.

    The action does not check for obstacles ahead; the rule that submits it does. The robot starts to drive when a tenth
    of the turn is left, while it is still rotating.

    To protect the corners of the hull, the turn is limited to the angle in the signal `free_turn`, if the robot has
    this signal. If less than half of the requested turn is free, the robot first backs off over ground that is known to
    be free.

    Attributes:
        turn: Turn angle, left positive [rad].
        duration: Duration of the straight drive [s].
        speed: Speed of the straight drive [m/s].
        rate: Turn rate [rad/s].
    """

    turn: Radians
    duration: PositiveSeconds = 2.0
    speed: MetresPerSecond = 0.25
    rate: PositiveRadiansPerSecond = 1.5

    def decompose(self, body: Body) -> Iterator[Action]:
        if abs(free_turn(body, self.turn)) < 0.5 * abs(self.turn) and (back := min(room_back(body), BACK)) > 0.0:
            yield hold_twist(body, Twist2(-BACKING), back / BACKING)
        turn = free_turn(body, self.turn)
        yield TurnAngle(angle=turn, rate=self.rate, tolerance=max(LEFT * abs(turn), TurnAngle.tolerance))
        yield hold_twist(body, Twist2(self.speed), self.duration)
