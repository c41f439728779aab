"""Turning on the spot: by an angle, to an angle, toward a position, back to the initial heading."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from ..action import Action, AtomicAction, Body, Failure, MacroAction, Progress, Reason
from ..geometry import Pose2, Twist2, wrap_angle
from ..units import Metres, PositiveRadians, PositiveRadiansPerSecond, Radians
from .pose import PoseWatch
from .stop import Stop

SLOWEST = 0.08  # [rad/s] below which real wheels stand still
SLACK = 3.0  # [s] that a turn may take beyond twice its ideal time


@dataclass(kw_only=True, eq=False)
class TurnAngle(AtomicAction):
    """Turn on the spot by an angle, in closed loop on the yaw, speeding up and braking within the wheels' limits.

    The angle counts from where the robot looks when the turn begins, and is kept then: an `update` while it turns
    changes the rate only. Turns of more than half a round go the way that the sign says. Without a valid pose the
    wheels stand, and the turn fails (LOST_POSE) if that lasts.

    Attributes:
        angle: How far, left positive [rad].
        rate: Fastest turn [rad/s].
        tolerance: When it is done [rad].
    """

    angle: Radians
    rate: PositiveRadiansPerSecond = 1.5
    tolerance: PositiveRadians = 0.02
    _left: float | None = field(default=None, init=False, repr=False)
    _yaw: float = field(default=0.0, init=False, repr=False)
    _speed: float = field(default=0.0, init=False, repr=False)
    _deadline: float = field(default=math.inf, init=False, repr=False)
    _watch: PoseWatch = field(default_factory=PoseWatch, init=False, repr=False)

    def act(self, body: Body) -> Progress | Failure:
        pose = self._watch.look(body)
        if pose is None:
            self._speed = 0.0
            body.wheels.command([0.0] * len(body.drive.wheels))
            return Progress.RUNNING
        if self._left is None:
            if not (math.isfinite(self.angle) and self.rate > 0.0):
                return Failure(Reason.CANNOT, f"an angle of {self.angle} rad at a rate of {self.rate} rad/s")
            self._left = self.angle
            self._deadline = body.clock.now() + 2.0 * abs(self.angle) / self.rate + SLACK
        else:
            self._left -= wrap_angle(pose.yaw - self._yaw)
        self._yaw = pose.yaw
        if abs(self._left) <= self.tolerance:
            return Progress.SUCCEEDED
        if body.clock.now() > self._deadline:
            degrees = math.degrees(self._left)
            return Failure(Reason.TIMEOUT, f"{degrees:.0f} of {math.degrees(self.angle):.0f} deg were left")
        self._speed = self._next_speed(body, self._left)
        wheels = body.drive.wheel_speeds(Twist2(0.0, turn=self._speed))
        body.wheels.command(wheels.tolist())
        return Progress.RUNNING

    def _next_speed(self, body: Body, left: float) -> float:
        """The turn rate of the next period [rad/s]: as fast as it may, and as it can still brake."""
        limit: float = body.drive.max_wheel_acceleration / body.drive.arm
        # Motors that answer late go on turning as they do now: what that takes is not left.
        late = max(self._speed * math.copysign(body.follower.settings.late, left), 0.0)
        rest = max(abs(left) - late, 0.0)
        # Braking is planned at half the limit and ends in a decay over two periods: the wheels follow late.
        brake = min(math.sqrt(limit * rest), 0.5 * rest / body.period)
        rate = max(min(self.rate, body.drive.turn_limit, brake), SLOWEST)
        wanted = math.copysign(min(rate, rest / body.period), left)
        return min(max(wanted, self._speed - limit * body.period), self._speed + limit * body.period)


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


@dataclass(kw_only=True, eq=False)
class TurnToOrigin(MacroAction):
    """Turn on the spot until the robot looks at the world frame's origin.

    Attributes:
        rate: Fastest turn [rad/s].
    """

    rate: PositiveRadiansPerSecond = 1.5

    def decompose(self, body: Body) -> Iterator[Action]:
        yield TurnToPosition(x=0.0, y=0.0, rate=self.rate)


@dataclass(kw_only=True, eq=False)
class TurnTo(MacroAction):
    """Turn on the spot, the short way round, to a yaw of the world frame; checked when the robot stands.

    Attributes:
        yaw: In the world frame [rad].
        rate: Fastest turn [rad/s].
        tolerance: When it is done [rad].
    """

    yaw: Radians
    rate: PositiveRadiansPerSecond = 1.5
    tolerance: PositiveRadians = 0.02

    def decompose(self, body: Body) -> Iterator[Action]:
        watch = PoseWatch()
        while True:
            pose = watch.look(body)
            if pose is not None:
                error = wrap_angle(self.yaw - pose.yaw)
                if abs(error) <= self.tolerance:
                    return
                yield TurnAngle(angle=error, rate=self.rate, tolerance=self.tolerance)
            yield Stop(patience=body.period)
