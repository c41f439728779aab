"""RegisteredDriver: driver of sensors and actuators on hardware that a package registers in `rocs_bt.devices`."""

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
    raise InputError("the driver has no device of this kind.")  # its keys are refused before


@dataclass(frozen=True)
class RegisteredDriver:
    """Driver with a registered name, which a robot.toml gives as `driver`.

    Attributes:
        title: Name of its system in messages, such as `ROS 2`.
        keys: Class of the device's keys, for `sensor` and `actuator`; one without devices of a kind lacks it.
        sensor: Makes a sensor that is read at a rate.
        actuator: Maker of an actuator; of an isolated one (True) it is called in a process of its own.
    """

    title: str
    keys: Mapping[str, type[Value]]
    sensor: Callable[[RobotSpec, SensorSpec, Host, Rate], Sensor] = _none
    actuator: Callable[[RobotSpec, ActuatorSpec, bool], ActuatorMaker] = _none


def registered_driver(name: str) -> RegisteredDriver | None:
    """Driver that a package has registered; None if none has this name.

    Raises:
        InputError: It cannot be loaded.
    """
    if name not in registered("rocs_bt.devices"):
        return None
    found: RegisteredDriver = load("rocs_bt.devices", name)
    return found
