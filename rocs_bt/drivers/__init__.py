"""Drivers of devices: in MuJoCo, in a mock without physics, from a recording, and isolated in a process.

robot.toml names a driver; each backend has its own class of that name, with the same parameters. Imported by
`simulation` and by `catalog`, which knows their parameters; blocks know `Sensor` and `Actuator` only.
"""

from .parameters import (
    DRIVER_PARAMETERS,
    GyroParameters,
    LidarParameters,
    MailboxParameters,
    OrientationParameters,
    PositionParameters,
    RangeConeParameters,
    RobotSensorParameters,
    VelocityParameters,
    WheelSpeedParameters,
    WheelTravelParameters,
    constructor_parameters,
    driver_class,
    parameters_of_driver,
    read_parameters,
)

__all__ = [
    "DRIVER_PARAMETERS",
    "GyroParameters",
    "LidarParameters",
    "MailboxParameters",
    "OrientationParameters",
    "PositionParameters",
    "RangeConeParameters",
    "RobotSensorParameters",
    "VelocityParameters",
    "WheelSpeedParameters",
    "WheelTravelParameters",
    "constructor_parameters",
    "driver_class",
    "parameters_of_driver",
    "read_parameters",
]
