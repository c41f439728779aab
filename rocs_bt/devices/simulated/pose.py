"""Sensors of the pose and of the motion of a body."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Annotated, ClassVar

import numpy as np

from ...base.errors import InputError
from ...base.geometry import Pose2, Twist2, along_arc, wrap_angle
from ...base.units import LENGTH, NONE, NOT_NEGATIVE, TIME, Bounds, MetresPerSecond, Radians, RadiansPerSecond
from ...control.locomotion import Array, Locomotion
from .device import SimulatedSensor
from .scene import Scene

Share = Annotated[float, NONE, Bounds(0.0, 1.0)]
Distance = Annotated[float, LENGTH, NOT_NEGATIVE]
AngleNoise = Annotated[Radians, NOT_NEGATIVE]
_TurnNoise = Annotated[RadiansPerSecond, NOT_NEGATIVE]
_Interval = Annotated[float, TIME, Bounds(0.0, above=True, infinite=True)]


class PoseSensor(SimulatedSensor):
    """Base class of sensors of the pose, with their errors beside the noise.

    Attributes:
        odometry: Relative error of an odometer that replaces the true pose; 0 for the true pose.
        drift: Standard deviation of the change of the error of x and of y in a second, a random walk [m].
        jump: Standard deviation of the error of x and of y that is sampled again at each jump [m].
        jump_every: Mean time between two jumps [s]; they come at random.
        errors: Number of values with these errors.
    """

    errors: ClassVar[int]
    odometry: Share = 0.0
    drift: Distance = 0.0
    jump: Distance = 0.0
    jump_every: _Interval = 10.0

    def set_up(self) -> None:
        self.odometer: Odometer | None = None
        self._walk, self._jumped, self._at = np.zeros(self.errors), np.zeros(self.errors), math.nan
        if self.drift or self.jump:
            self._faults_rng = self.faults_rng()

    @property
    def exact(self) -> bool:
        """Whether the readings are ground truth."""
        return not (self.drift or self.jump or self.noise or self.odometry)

    def base(self) -> Pose2:
        """Pose of the base, true or of the odometer, which all sensors of a robot share."""
        return self.world.pose(self.robot) if self.odometer is None else self.odometer.pose()

    def error(self) -> list[float]:
        """Errors beside the noise at present, shape (errors,); the first one is 0."""
        passed = self.world.stamp - self._at
        if passed > 0.0:
            if self.drift:
                self._walk += self.drift * math.sqrt(passed) * self._faults_rng.standard_normal(self.errors)
            if self.jump and self._faults_rng.random() < -math.expm1(-passed / self.jump_every):
                self._jumped = self.jump * self._faults_rng.standard_normal(self.errors)
        self._at = self.world.stamp
        errors: list[float] = (self._walk + self._jumped).tolist()
        return errors


class Position(PoseSensor):
    """Position sensor: x, y, z of the base [m], world frame."""

    size: ClassVar[int] = 3
    errors: ClassVar[int] = 2

    def sample(self) -> list[float]:
        found = [*self.world.pose3(self.robot)[:3]]
        if self.odometer is not None:
            found[:2] = self.base()[:2]
        if self.drift or self.jump:
            x, y = self.error()
            found[:2] = found[0] + x, found[1] + y
        return found


class Orientation(PoseSensor):
    """Orientation sensor: yaw of the base [rad], world frame.

    Attributes:
        drift: Standard deviation of the change of the error in a second, a random walk [rad].
        jump: Standard deviation of the error that is sampled again at each jump [rad].
    """

    size: ClassVar[int] = 1
    errors: ClassVar[int] = 1
    drift: AngleNoise = 0.0
    jump: AngleNoise = 0.0

    def sample(self) -> list[float]:
        yaw = self.base().yaw
        return [wrap_angle(yaw + self.error()[0]) if self.drift or self.jump else yaw]


class TwistSensor(SimulatedSensor):
    """Twist sensor: velocity of the base, forward, left and up [m/s], and turn rate, left positive [rad/s].

    Forward and left are horizontal, up and the axis of the turn are vertical, also while the body tilts.

    Attributes:
        speed_noise: Standard deviation of each speed [m/s].
        turn_noise: Standard deviation of the turn rate [rad/s].
    """

    size: ClassVar[int] = 4
    speed_noise: Annotated[MetresPerSecond, NOT_NEGATIVE] = 0.0
    turn_noise: _TurnNoise = 0.0

    def set_up(self) -> None:
        if self.noise > 0.0:
            raise InputError(f"twist sensor '{self.name}' does not take 'noise'. Use speed_noise and turn_noise.")
        self._scale = [*[self.speed_noise] * 3, self.turn_noise]

    def sample(self) -> list[float]:
        errors = self.rng.normal(0.0, self._scale).tolist() if any(self._scale) else [0.0] * 4
        return [value + e for value, e in zip(self.world.twist3(self.robot), errors, strict=True)]


class Attitude(SimulatedSensor):
    """Attitude sensor: roll and pitch of the base [rad], as in `Pose3`."""

    size: ClassVar[int] = 2

    def sample(self) -> list[float]:
        pose = self.world.pose3(self.robot)
        return [pose.roll, pose.pitch]


class Height(SimulatedSensor):
    """Height sensor: height of the base [m], world frame."""

    size: ClassVar[int] = 1

    def sample(self) -> list[float]:
        return [self.world.pose3(self.robot).z]


class Gyro(SimulatedSensor):
    """Gyro: mean yaw rate since the previous reading [rad/s], left positive.

    The reading is a mean and not an instantaneous rate, because a real device samples at about 1 kHz and integrates, so
    that vibrations between two readings are averaged. The heading must change by less than pi between two readings.

    Attributes:
        bias_noise: Standard deviation from which the constant bias is sampled [rad/s].
    """

    size: ClassVar[int] = 1
    bias_noise: _TurnNoise = 0.0

    def set_up(self) -> None:
        self._bias = self.bias_noise * float(self.rng.normal())
        self._sampled_at = self._yaw = math.nan

    def sample(self) -> list[float]:
        stamp, yaw = self.world.stamp, self.world.pose(self.robot).yaw
        passed = stamp - self._sampled_at
        rate = wrap_angle(yaw - self._yaw) / passed if passed > 0.0 else 0.0  # 0 at the first reading
        self._sampled_at, self._yaw = stamp, yaw
        return [rate + self._bias]


class Odometer:
    """Dead reckoning from the pose at the first reading; it is never corrected.

    The way is that of the wheels' shafts, which turn while the wheels slip, too. On a body without wheels it is that of
    the base. It is wrong by a share that is sampled once, as by a wrong wheel radius. The yaw is that of a gyro: of the
    base, with an error that grows as a random walk.

    Args:
        world: World of the robot.
        robot: Name of the robot.
        share: Standard deviation of the relative error of the way, and of the change of the yaw's error in a second
            [rad].
        rng: Random generator of the errors.
        travel: Function that returns the travel of each wheel since the start [m]; None without wheels.
        locomotion: Locomotion of the robot, with its wheels in this order.
    """

    def __init__(
        self,
        world: Scene,
        robot: str,
        share: float,
        rng: np.random.Generator,
        travel: Callable[[], Sequence[float]] | None,
        locomotion: Locomotion,
    ) -> None:
        self._world, self._robot, self._share, self._rng = world, robot, share, rng
        self._travel, self._locomotion = travel, locomotion
        self._scale = 1.0 + share * float(rng.standard_normal())
        self._last: tuple[float, Pose2, Array] | None = None  # time, true pose, travel at the last call
        self._pose = Pose2(math.nan, math.nan, math.nan)

    def pose(self) -> Pose2:
        """Pose at the present state of the world, world frame."""
        stamp, true = self._world.stamp, self._world.pose(self._robot)
        travel = np.array(self._travel() if self._travel else ())
        if self._last is None:
            self._pose = true
        elif stamp != self._last[0]:
            turn = wrap_angle(true.yaw - self._last[1].yaw)
            forward, left = self._way(self._last[1], turn, true, travel - self._last[2])
            turn += self._share * math.sqrt(stamp - self._last[0]) * float(self._rng.standard_normal())
            self._pose = along_arc(self._pose, Twist2(self._scale * forward, turn, self._scale * left), 1.0)
        self._last = stamp, true, travel
        return self._pose

    def _way(self, before: Pose2, turn: float, true: Pose2, travel: Array) -> tuple[float, float]:
        """Way of the base since the last call, forward and left [m]."""
        if self._travel:
            twist = self._locomotion.twist(travel)
            return twist.forward, twist.left
        c, s = math.cos(before.yaw + 0.5 * turn), math.sin(before.yaw + 0.5 * turn)
        dx, dy = true.x - before.x, true.y - before.y
        return c * dx + s * dy, c * dy - s * dx
