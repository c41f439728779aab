"""`driver = "ros2"`: sensors that read topics, and actuators that publish commands."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final, cast

from ...catalog.registered_devices import RegisteredDevices
from .parameters import Ros2ActuatorParameters, Ros2SensorParameters

if TYPE_CHECKING:
    from ...base.clock import Rate
    from ...catalog import ActuatorSpec, RobotSpec, SensorSpec
    from ...devices.host import Host
    from ..settings import Ros2Settings
    from .actuator_node import ActuatorNodeMaker
    from .sensor_node import SensorNode


def _sensor(robot: RobotSpec, spec: SensorSpec, host: Host, rate: Rate) -> SensorNode:
    from .actuator_node import shared_node
    from .sensor_node import SensorNode

    given = cast(Ros2SensorParameters, spec.parameters)
    node = shared_node(_settings(robot), host)
    return SensorNode(spec.name, node, given, given.scale(spec.scale), spec.validity(rate.period))


def _actuator(robot: RobotSpec, spec: ActuatorSpec, isolated: bool) -> ActuatorNodeMaker:
    from .actuator_node import ActuatorNodeMaker, isolated_node

    given = cast(Ros2ActuatorParameters, spec.parameters)
    locomotion = robot.locomotion
    made = ActuatorNodeMaker(spec.name, _settings(robot), given, locomotion)
    return replace(made, node=isolated_node(spec.name)) if isolated else made


def _settings(robot: RobotSpec) -> Ros2Settings:
    from ..settings import Ros2Settings

    settings: Ros2Settings = robot.tables.get("ros2", Ros2Settings())
    return settings


DRIVER: Final = RegisteredDevices(
    "ROS 2",
    {"sensor": Ros2SensorParameters, "actuator": Ros2ActuatorParameters},
    _sensor,
    _actuator,
    source=lambda robot, name: _settings(robot).topic(name),
    simulated=lambda robot: _settings(robot).use_sim_time,
)
