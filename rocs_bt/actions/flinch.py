"""Flinch: away from what is too close."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

from ..action import AtomicAction, Body, Failure, Progress, Reason
from ..geometry import Pose2, Twist2
from ..units import NOT_NEGATIVE, MetresPerSecond, PositiveMetres, PositiveSeconds
from .room import bend_off

STANDS = 0.05  # [m/s] below which wheels that are told to stand do
PUSHED = 0.04  # [m] that a robot must be pushed before it drives back, ...
BACK = 0.01  # [m] ... until so little is left
LOST = 0.3  # [m] off, where it was carried away or could not help it: there it stands anew
JUMP = 0.6  # [m/s] faster than which nobody pushes: a better fix
PULL = 8.0  # [1/s] how fast it drives back for each metre


@dataclass
class _Course:
    """Ahead, back or standing, and what came of it so far."""

    sign: int  # 1 ahead, -1 back, 0 standing
    begun: float  # [s]
    start: Pose2 | None = None  # where its pose was first known; standing, where it came to stand
    last: Pose2 | None = None  # standing, where it was a period ago
    blind: float = 0.0  # [m] that it was told to drive without a pose
    pushed: bool = False  # whether it drives back to where it stood


@dataclass(kw_only=True, eq=False)
class Flinch(AtomicAction):
    """Drive forward or backward until some distance is gained, or stand.

    It goes straight, or on the bend on which there is room; a bend is told by the signal `bend_off`, where a monitor
    knows of peers and of ground that is free. The distance is measured by the pose; while that is lost, by the
    commanded speed, because a reflex must not wait.

    Without a speed it stands until an `update` gives it one. Locked wheels alone slide before another robot that
    drives on, into what is behind them. With `resist` they turn against it once it has pushed the robot 0.04 m ahead
    or back, until it is where it came to stand, or has lost 0.3 m and stands there anew. From the side, or without
    pose or speed, it lets itself be pushed; a pose that jumps is no push.

    An `update` that asks for another of the three, ahead, back or standing, begins distance and timeout anew.

    Attributes:
        speed: How fast, negative backward, 0 to stand [m/s].
        distance: How far [m].
        timeout: After which it fails; not while it stands [s].
        resist: How fast at most to drive back to where it stood, when pushed [m/s].
    """

    speed: MetresPerSecond
    distance: PositiveMetres = 0.08
    timeout: PositiveSeconds = 1.5
    resist: Annotated[MetresPerSecond, NOT_NEGATIVE] = 0.0
    _course: _Course | None = field(default=None, init=False, repr=False)

    def act(self, body: Body) -> Progress | Failure:
        now = body.clock.now()
        sign = (self.speed > 0.0) - (self.speed < 0.0)
        if self._course is None or self._course.sign != sign:
            self._course = _Course(sign, now)
        if sign == 0:
            _drive(body, self._back(body, self._course))
            return Progress.RUNNING
        gained = self._gained(body, self._course)
        if gained >= self.distance:
            return Progress.SUCCEEDED
        if now - self._course.begun > self.timeout - 0.5 * body.period:
            return Failure(Reason.TIMEOUT, f"gained {gained:.2f} m of {self.distance:.2f} m in {self.timeout:.1f} s")
        _drive(body, self.speed, bend_off(body, self.speed))
        return Progress.RUNNING

    def _gained(self, body: Body, course: _Course) -> float:
        """How far it is from where it began [m]."""
        pose = _pose(body)
        if pose is None:
            course.blind += abs(self.speed) * body.period
            return course.blind
        course.start = course.start or pose
        return course.sign * _ahead(course.start, pose)

    def _back(self, body: Body, course: _Course) -> float:
        """How fast to drive to where it came to stand [m/s]."""
        pose, last, speed = _pose(body), course.last, body.knowledge.robot.speed(body.clock.now())
        course.last = pose
        if pose is None or last is None or pose.distance(last) > JUMP * body.period or math.isnan(speed):
            course.start = None
        if pose is None or course.start is None or pose.distance(course.start) > LOST:
            course.start, course.pushed = pose if abs(speed) < STANDS else None, False
            return 0.0
        off = _ahead(pose, course.start)
        course.pushed = self.resist > 0.0 and abs(off) > (BACK if course.pushed else PUSHED)
        return math.copysign(min(PULL * abs(off), self.resist), off) if course.pushed else 0.0


def _pose(body: Body) -> Pose2 | None:
    """Where the robot is; None while that is lost."""
    pose = body.knowledge.robot.pose(body.clock.now())
    return pose if all(map(math.isfinite, pose)) else None


def _ahead(pose: Pose2, place: Pose2) -> float:
    """How far ahead of a pose a place is [m]."""
    return pose.distance(place) * math.cos(pose.bearing(place))


def _drive(body: Body, speed: float, bend: float = 0.0) -> None:
    twist = Twist2(speed, speed * bend)
    body.wheels.command(body.drive.wheel_speeds(twist).tolist())
