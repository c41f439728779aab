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
    from .actuator_node import ActuatorNodeMaker
    from .sensor_node import SensorNode


def _sensor(robot: RobotSpec, spec: SensorSpec, host: Host, rate: Rate) -> SensorNode:
    from ..settings import Ros2Settings
    from .actuator_node import shared_node
    from .sensor_node import SensorNode

    given = cast(Ros2SensorParameters, spec.parameters)
    node = shared_node(robot.tables.get("ros2", Ros2Settings()), host)
    return SensorNode(spec.name, node, given, given.scale(spec.scale), spec.validity(rate.period))


def _actuator(robot: RobotSpec, spec: ActuatorSpec, isolated: bool) -> ActuatorNodeMaker:
    from ..settings import Ros2Settings
    from .actuator_node import ActuatorNodeMaker, isolated_node

    given = cast(Ros2ActuatorParameters, spec.parameters)
    locomotion = robot.locomotion
    made = ActuatorNodeMaker(spec.name, robot.tables.get("ros2", Ros2Settings()), given, locomotion)
    return replace(made, node=isolated_node(spec.name)) if isolated else made


DRIVER: Final = RegisteredDevices(
    "ROS 2", {"sensor": Ros2SensorParameters, "actuator": Ros2ActuatorParameters}, _sensor, _actuator
)
