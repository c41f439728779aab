"""Turns on the spot: by an angle, to a yaw, toward a position, toward the origin."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ..base.geometry import Pose2, Twist2, wrap_angle
from ..base.units import Metres, PositiveRadians, PositiveRadiansPerSecond, Radians
from ..interfaces.action import Action, AtomicAction, Body, Failure, MacroAction, Progress, Reason
from .pose import PoseWatch
from .stop import Stop

SLOWEST = 0.08  # [rad/s] minimum turn rate, because real robots do not turn at lower rates
SLACK = 3.0  # [s] time limit of a turn, in addition to twice its ideal duration


class TurnAngle(AtomicAction):
    """Turn on the spot by an angle, with feedback from the yaw and within the acceleration limits of the body.

    The angle counts from the yaw at the start of the turn. An `update` during the turn changes only the rate. The sign
    gives the direction, also for angles beyond half a revolution. Without a valid pose the robot stops, and the turn
    fails with LOST_POSE if the pose stays lost.

    Attributes:
        angle: Turn angle, left positive [rad].
        rate: Maximum turn rate [rad/s].
        tolerance: Final error at which the turn succeeds [rad].
    """

    angle: Radians
    rate: PositiveRadiansPerSecond = 1.5
    tolerance: PositiveRadians = 0.02
    _left: float | None = None
    _yaw: float = 0.0
    _speed: float = 0.0
    _deadline: float = math.inf

    def __post_init__(self) -> None:
        self._watch = PoseWatch()

    def act(self, body: Body) -> Progress | Failure:
        pose = self._watch.read(body)
        if pose is None:
            self._speed = 0.0
            body.rest()
            return Progress.RUNNING
        if self._left is None:
            if not (math.isfinite(self.angle) and self.rate > 0.0):
                return Failure(Reason.CANNOT, f"an angle of {self.angle} rad at a rate of {self.rate} rad/s")
            self._left = self.angle
            ideal = abs(self.angle) / min(self.rate, body.locomotion.turn_limit)
            self._deadline = body.clock.now() + 2.0 * ideal + SLACK
        else:
            self._left -= wrap_angle(pose.yaw - self._yaw)
        self._yaw = pose.yaw
        if abs(self._left) <= self.tolerance:
            return Progress.SUCCEEDED
        if body.clock.now() > self._deadline:
            degrees = math.degrees(self._left)
            return Failure(Reason.TIMEOUT, f"{degrees:.0f} of {math.degrees(self.angle):.0f} deg were left")
        self._speed = self._next_speed(body, self._left)
        body.move(Twist2(0.0, turn=self._speed))
        return Progress.RUNNING

    def _next_speed(self, body: Body, left: float) -> float:
        """Turn rate of the next period [rad/s]: the highest from which the robot can still brake in time.

        Args:
            body: Robot.
            left: Angle that is left to turn, left positive [rad].
        """
        limit = body.locomotion.turn_acceleration_limit
        # During the delay of its response the robot continues at its present rate.
        late = max(self._speed * math.copysign(body.locomotion.response.late, left), 0.0)
        rest = max(abs(left) - late, 0.0)
        # Braking is planned at half the limit and ends in a decay over two periods, because the body lags.
        brake = min(math.sqrt(limit * rest), 0.5 * rest / body.period)
        rate = max(min(self.rate, body.locomotion.turn_limit, brake), SLOWEST)
        wanted = math.copysign(min(rate, rest / body.period), left)
        return min(max(wanted, self._speed - limit * body.period), self._speed + limit * body.period)


class TurnToPosition(MacroAction):
    """Turn on the spot toward a position: one TurnAngle by the bearing at the start.

    Attributes:
        x: Position, world frame [m].
        y: Position, world frame [m].
        rate: Maximum turn rate [rad/s].
    """

    x: Metres
    y: Metres
    rate: PositiveRadiansPerSecond = 1.5

    def decompose(self, body: Body) -> Iterator[Action]:
        watch = PoseWatch()
        while (pose := watch.read(body)) is None:
            yield Stop(patience=body.period)
        yield TurnAngle(angle=pose.bearing(Pose2(self.x, self.y)), rate=self.rate)


class TurnToOrigin(MacroAction):
    """Turn on the spot toward the origin of the world frame.

    Attributes:
        rate: Maximum turn rate [rad/s].
    """

    rate: PositiveRadiansPerSecond = 1.5

    def decompose(self, body: Body) -> Iterator[Action]:
        yield TurnToPosition(x=0.0, y=0.0, rate=self.rate)


class TurnTo(MacroAction):
    """Turn on the spot in the shorter direction to a yaw; the error is checked at standstill and corrected.

    Attributes:
        yaw: Final yaw, world frame [rad].
        rate: Maximum turn rate [rad/s].
        tolerance: Final error at which the turn succeeds [rad].
    """

    yaw: Radians
    rate: PositiveRadiansPerSecond = 1.5
    tolerance: PositiveRadians = 0.02

    def decompose(self, body: Body) -> Iterator[Action]:
        watch = PoseWatch()
        while True:
            pose = watch.read(body)
            if pose is not None:
                error = wrap_angle(self.yaw - pose.yaw)
                if abs(error) <= self.tolerance:
                    return
                yield TurnAngle(angle=error, rate=self.rate, tolerance=self.tolerance)
            yield Stop(patience=body.period)
