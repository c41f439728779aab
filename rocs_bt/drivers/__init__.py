"""Drivers of devices, by backend: MuJoCo, mock without physics, replay of a recording, isolated process.

robot.toml names a driver; each backend has a class for this name, with the same parameters. Only `simulation` and
`catalog` import this package; the blocks of an agent use only the interfaces `Sensor` and `Actuator`.
"""

from .parameters import (
    DRIVER_PARAMETERS,
    ROS2,
    AttitudeParameters,
    BatteryParameters,
    GyroParameters,
    HeightParameters,
    LidarParameters,
    MailboxParameters,
    OrientationParameters,
    PositionParameters,
    RangeConeParameters,
    RobotSensorParameters,
    TwistParameters,
    VelocityParameters,
    WheelSpeedParameters,
    WheelTravelParameters,
    declared_parameters,
    driver_class,
)

__all__ = [
    "DRIVER_PARAMETERS",
    "ROS2",
    "AttitudeParameters",
    "BatteryParameters",
    "GyroParameters",
    "HeightParameters",
    "LidarParameters",
    "MailboxParameters",
    "OrientationParameters",
    "PositionParameters",
    "RangeConeParameters",
    "RobotSensorParameters",
    "TwistParameters",
    "VelocityParameters",
    "WheelSpeedParameters",
    "WheelTravelParameters",
    "declared_parameters",
    "driver_class",
]
