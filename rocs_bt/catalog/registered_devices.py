"""RegisteredDevices: sensors and actuators on hardware that a package registers in `rocs_bt.devices`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

from ..base.errors import InputError
from ..base.registered import load, registered

if TYPE_CHECKING:
    from ..base.clock import Rate
    from ..declare import Value
    from ..devices.host import Host
    from ..devices.isolated import ActuatorMaker
    from ..interfaces.device import Sensor
    from .device_spec import ActuatorSpec, SensorSpec
    from .robot_spec import RobotSpec


def _none(*place: object) -> NoReturn:
    raise InputError("there is no registered device of this kind.")  # its keys are refused before


@dataclass(frozen=True)
class RegisteredDevices:
    """Devices with a registered name, which a robot.toml gives as `driver`.

    Attributes:
        title: Name of its system in messages, such as `ROS 2`.
        keys: Class of the keys, for `sensor` and `actuator`; a kind without devices is missing.
        sensor: Makes a sensor that is read at a rate.
        actuator: Maker of an actuator; of an isolated one (True) it is called in a process of its own.
        source: Full name of a source that a device's table names, such as a topic.
        simulated: Whether the robot is that of a simulator, which can be stopped without danger.
    """

    title: str
    keys: Mapping[str, type[Value]]
    sensor: Callable[[RobotSpec, SensorSpec, Host, Rate], Sensor] = _none
    actuator: Callable[[RobotSpec, ActuatorSpec, bool], ActuatorMaker] = _none
    source: Callable[[RobotSpec, str], str] = lambda robot, name: name
    simulated: Callable[[RobotSpec], bool] = lambda robot: False


def registered_devices(name: str) -> RegisteredDevices | None:
    """Devices that a package has registered; None if none have this name.

    Raises:
        InputError: They cannot be loaded.
    """
    if name not in registered("rocs_bt.devices"):
        return None
    found: RegisteredDevices = load("rocs_bt.devices", name)
    return found
