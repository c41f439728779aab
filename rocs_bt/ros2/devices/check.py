"""Check of devices with `driver = "ros2"`: message types and their fields, if the package rosbags is installed."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator

from ...base.errors import Fault, InputError
from ...catalog import ActuatorSpec, RobotSpec
from ...drivers import ROS2, Ros2Settings, read_parameters
from ..messages.message_types import MessageTypes
from ..network.rclpy_transport import definition
from .parameters import Ros2SensorParameters


def ros2_faults(robot: RobotSpec) -> Iterator[Fault]:
    """Check the message types of a robot's sensors against its distribution of ROS 2; nothing is connected."""
    for actuator in robot.actuators:
        if actuator.driver == ROS2:
            yield from not_isolated(robot, actuator)
    sensors = [sensor for sensor in robot.sensors if sensor.driver == ROS2]
    if not sensors or importlib.util.find_spec("rosbags") is None:
        return
    settings = robot.ros2 or Ros2Settings()
    try:
        types = MessageTypes(settings.distro, lambda name: settings.definition(name) or definition(name))
    except InputError as error:  # an unknown distribution
        yield from error.at(robot.file, *robot.positions.get("ros2.distro", (0, 0))).faults
        return
    for sensor in sensors:
        try:
            given = read_parameters(Ros2SensorParameters, sensor.parameters, f"sensor '{sensor.name}'")
            given.make_take(types)
            given.message_size(types)
        except InputError as error:
            yield from error.at(robot.file, sensor.line).faults


def not_isolated(robot: RobotSpec, actuator: ActuatorSpec) -> Iterator[Fault]:
    """Warn of an actuator on hardware that no other process stops, unless the robot follows a simulator's clock."""
    if not actuator.isolated and not (robot.ros2 is not None and robot.ros2.use_sim_time):
        message = f"nothing sends neutral to '{actuator.name}' if this program hangs, is stopped or killed."
        hint = "Write isolated = true, unless only one program can open the line and it also carries the sensors."
        yield Fault(message, robot.file, actuator.line, hint=hint, warning=True)
