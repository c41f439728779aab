"""Flinch: away from what is too close."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ..action import AtomicAction, Body, Failure, Progress, Reason
from ..geometry import Pose2, Twist2
from ..units import MetresPerSecond, PositiveMetres, PositiveSeconds
from .room import bend_off


@dataclass(kw_only=True, eq=False)
class Flinch(AtomicAction):
    """Drive forward or backward until some distance is gained: straight, or on the bend on which there is room.

    A bend is told by the signal `bend_off`, where a monitor knows of peers and of ground that is free.

    The distance is measured by the pose; while that is lost, by the commanded speed, because a reflex must not wait.
    An `update` that turns the direction round begins to measure anew.

    Attributes:
        speed: How fast, negative backward [m/s].
        distance: How far [m].
        timeout: After which it fails [s].
    """

    speed: MetresPerSecond
    distance: PositiveMetres = 0.08
    timeout: PositiveSeconds = 1.5
    _begun: float | None = field(default=None, init=False, repr=False)
    _start: Pose2 | None = field(default=None, init=False, repr=False)
    _forward: bool = field(default=True, init=False, repr=False)
    _blind: float = field(default=0.0, init=False, repr=False)

    def act(self, body: Body) -> Progress | Failure:
        now = body.clock.now()
        if self._begun is None:
            self._begun = now
        if self._forward is not (self.speed >= 0.0):
            self._forward, self._start, self._blind = self.speed >= 0.0, None, 0.0
        gained = self._gained(body)
        if gained >= self.distance:
            return Progress.SUCCEEDED
        if now - self._begun > self.timeout - 0.5 * body.period:
            return Failure(Reason.TIMEOUT, f"gained {gained:.2f} m of {self.distance:.2f} m in {self.timeout:.1f} s")
        twist = Twist2(self.speed, self.speed * bend_off(body, self.speed))
        body.wheels.command(body.drive.saturate(body.drive.wheel_speeds(twist)).tolist())
        return Progress.RUNNING

    def _gained(self, body: Body) -> float:
        pose = body.knowledge.robot.pose(body.clock.now())
        if not all(map(math.isfinite, pose)):
            self._blind += abs(self.speed) * body.period
            return self._blind
        if self._start is None:
            self._start = pose
        ahead = (pose.x - self._start.x) * math.cos(self._start.yaw) + (pose.y - self._start.y) * math.sin(
            self._start.yaw
        )
        return ahead if self._forward else -ahead
