"""Check of devices with `driver = "ros2"`: message types and their fields, if the package rosbags is installed."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator

from ...base.errors import Fault, InputError
from ...catalog import RobotSpec
from ...declare import location_of
from ..messages.type_store import TypeStore
from ..network.rclpy_transport import definition
from ..settings import Ros2Settings
from .parameters import Ros2SensorParameters


def ros2_faults(robot: RobotSpec) -> Iterator[Fault]:
    """Check the message types of a robot's sensors against its distribution of ROS 2; nothing is connected."""
    sensors = [(s, s.parameters) for s in robot.sensors if isinstance(s.parameters, Ros2SensorParameters)]
    if not sensors or importlib.util.find_spec("rosbags") is None:
        return
    settings = robot.tables.get("ros2", Ros2Settings())
    try:
        types = TypeStore(settings.distro, lambda name: settings.definition(name) or definition(name))
    except InputError as error:  # an unknown distribution
        yield from error.at(robot.file, *location_of(settings, "distro")[1:]).faults
        return
    for sensor, given in sensors:
        try:
            given.make_take(types)
            given.message_size(types)
        except InputError as error:
            yield from error.at(robot.file, sensor.line).faults
