"""Odometry of a simulated robot from its wheel encoders."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..control.locomotion import Locomotion
from ..drivers.mujoco.sensors import WheelSpeed, WheelTravel
from ..geometry import Pose2, Pose3, Twist3, along_arc

Motion = tuple[float, Pose3, Twist3]
"""Time [s], pose in the frame `odom`, and velocity of a body."""


class WheelOdometry:
    """Dead reckoning from wheel encoders, from the pose 0 at the start; it drifts by slip.

    Args:
        sensor: Encoders.
        locomotion: Locomotion of the robot.
        motors: Names of the motors in the order of the locomotion's wheels.
    """

    def __init__(self, sensor: WheelSpeed | WheelTravel, locomotion: Locomotion, motors: Sequence[str]) -> None:
        self._sensor = sensor
        self._locomotion = locomotion
        self._order = [sensor.parameters.motors.index(motor) for motor in motors]
        self._pose = Pose2(0.0, 0.0)
        self._stamp = math.nan
        self._travel: list[float] = []

    def __call__(self) -> Motion:
        reading = self._sensor.read()
        values = [reading.values[i] for i in self._order]
        passed = 0.0 if math.isnan(self._stamp) else reading.stamp - self._stamp
        if isinstance(self._sensor, WheelTravel):
            before, self._travel = self._travel or values, values
            speeds = [(now - then) / passed if passed > 0.0 else 0.0 for now, then in zip(values, before, strict=True)]
        else:
            speeds = values
        twist = self._locomotion.twist(np.array(speeds))
        self._pose, self._stamp = along_arc(self._pose, twist, passed), reading.stamp
        x, y, yaw = self._pose
        return reading.stamp, Pose3(x, y, 0.0, yaw=yaw), Twist3(twist.forward, twist.left, 0.0, twist.turn)
