"""Odometry of a simulated robot from its wheel encoders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...base.geometry import Pose2, Pose3, Twist3, along_arc
from ...control.locomotion import Locomotion
from ...devices.simulated import WheelSpeed, WheelTravel
from ..messages.fields import UNMEASURED

EXACT = 1e-6
"""Variance of a quantity that is known exactly, SI units: filters take a variance of 0 for an unknown one."""

_PLANE = np.ix_((0, 1, 5), (0, 1, 5))  # x, y and yaw among x, y, z, roll, pitch and yaw


class Motion(NamedTuple):
    """Measured motion of a body.

    Attributes:
        stamp: Time [s].
        pose: Pose in the frame `odom`.
        twist: Velocity of the body.
        pose_covariance: Covariance of x, y, z, roll, pitch and yaw, 36 numbers in rows.
        twist_covariance: Covariance of the velocities along and about x, y and z, 36 numbers in rows.
    """

    stamp: float
    pose: Pose3
    twist: Twist3
    pose_covariance: Sequence[float]
    twist_covariance: Sequence[float]


class WheelOdometry:
    """Dead reckoning from wheel encoders, from the pose 0 at the start; it drifts by slip.

    The covariances are those of the encoders' noise and counts. Slip has no declared size, and is not in them.

    Args:
        sensor: Encoders.
        locomotion: Locomotion of the robot.
        motors: Names of the motors in the order of the locomotion's wheels.
        height: Height of the base over the ground [m].
    """

    def __init__(
        self, sensor: WheelSpeed | WheelTravel, locomotion: Locomotion, motors: Sequence[str], height: float
    ) -> None:
        self._sensor = sensor
        self._locomotion = locomotion
        self._order = [sensor.motors.index(motor) for motor in motors]
        self._height = height
        self._pose = Pose2(0.0, 0.0)
        self._stamp = math.nan
        self._travel: list[float] = []
        self._errors = np.zeros((3, 3))  # covariance of x, y and yaw
        twists = [locomotion.twist(wheel) for wheel in np.eye(len(motors))]
        self._of_wheels = np.array([(t.forward, t.left, t.turn) for t in twists]).T  # shape (3, n)

    def __call__(self) -> Motion:
        """Read the encoders."""
        reading = self._sensor.read()
        values = [reading.values[i] for i in self._order]
        passed = 0.0 if math.isnan(self._stamp) else reading.stamp - self._stamp
        if isinstance(self._sensor, WheelTravel):
            before, self._travel = self._travel or values, values
            speeds = [(now - then) / passed if passed > 0.0 else 0.0 for now, then in zip(values, before, strict=True)]
        else:
            speeds = values
        twist = self._locomotion.twist(np.array(speeds))
        errors = (self._of_wheels * self._variances(passed)) @ self._of_wheels.T + EXACT * np.eye(3)
        self._drift(errors, twist.forward * passed, twist.left * passed, passed)
        self._pose, self._stamp = along_arc(self._pose, twist, passed), reading.stamp
        x, y, yaw = self._pose
        pose, velocity = Pose3(x, y, self._height, yaw=yaw), Twist3(twist.forward, twist.left, 0.0, twist.turn)
        here = self._errors + EXACT * np.eye(3)
        return Motion(reading.stamp, pose, velocity, _in_space(here), _in_space(errors))

    def _variances(self, passed: float) -> npt.NDArray[np.float64]:
        """Variances of the wheels' speeds [m2/s2], shape (n,), after a time [s]."""
        noise, factors = self._sensor.noise, self._sensor.factors
        if not isinstance(self._sensor, WheelTravel):
            return np.full(len(self._order), noise**2)
        counts = np.array([factors[i] for i in self._order]) * math.tau / self._sensor.counts  # [m]
        both = 2.0 * (noise**2 + counts**2 / 12.0)  # of a difference of two readings, each rounded to counts
        return both / passed**2 if passed > 0.0 else np.zeros(len(self._order))

    def _drift(self, errors: npt.NDArray[np.float64], ahead: float, left: float, passed: float) -> None:
        """Add the errors of a twist, shape (3, 3), over a step [m] and a time [s] to those of the pose."""
        c, s = math.cos(self._pose.yaw), math.sin(self._pose.yaw)
        swung = np.array(((1.0, 0.0, -s * ahead - c * left), (0.0, 1.0, c * ahead - s * left), (0.0, 0.0, 1.0)))
        turned = passed * np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
        self._errors = swung @ self._errors @ swung.T + turned @ errors @ turned.T


def _in_space(plane: npt.NDArray[np.float64]) -> list[float]:
    """Covariance in space of one in the plane, shape (3, 3); the wheels do not measure the other quantities."""
    found = UNMEASURED * np.eye(6)
    found[_PLANE] = plane
    flat: list[float] = found.ravel().tolist()
    return flat
