"""Drivers of robot.toml: the shipped ones by name, a user's own by class and constructor arguments."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any

from ..arguments import read_arguments
from ..catalog import ActuatorSpec, Catalog, RobotSpec, SensorSpec, is_reference, running_class
from ..device import Actuator, Sensor
from ..drivers import constructor_parameters
from ..drivers.isolated import DeviceMaker, IsolatedActuator
from ..drivers.mujoco import MujocoActuator, MujocoSensor
from ..errors import DeviceError, Fault, InputError, located_at


@dataclass(frozen=True)
class Driver:
    """The driver of one device.

    Attributes:
        make: Its name, for a shipped one, or a user's own class.
        parameters: Arguments in SI units, by keyword.
    """

    make: Any
    parameters: Mapping[str, Any]

    def running(self, *passing: type[Exception]) -> AbstractContextManager[None]:
        """A context in which what a user's own class raises becomes a fault of its file; InputErrors pass."""
        return running_class(self.make, *passing) if isinstance(self.make, type) else nullcontext()


def mujoco_driver(catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec) -> Driver:
    """The driver of a device in simulation.

    Raises:
        InputError: A user's own class does not load, extends no driver of MuJoCo's, or does not take the device's keys;
            all faults at once.
    """
    if not is_reference(device.driver):
        return Driver(device.driver, device.parameters)
    wanted = MujocoSensor if isinstance(device, SensorSpec) else MujocoActuator
    cls = _class(catalog, robot, device)
    if not issubclass(cls, wanted):
        raise InputError(
            Fault(
                f"the driver '{cls.__name__}' of '{device.name}' is none for MuJoCo.",
                robot.file,
                device.line,
                hint=f"To simulate it extend rocs_bt.drivers.mujoco.{wanted.__name__}; to drive a real robot call "
                "rocs_bt.drive.",
            )
        )
    return _driver(cls, "mount", robot, device)


def hardware_driver(catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec) -> Driver:
    """The driver of a device on hardware: always a user's own class.

    Raises:
        InputError: The driver is a simulation's, or the class does not load, extends neither Sensor nor Actuator, or
            does not take the device's keys; all faults at once.
    """
    kind = Sensor if isinstance(device, SensorSpec) else Actuator
    with located_at(robot.file, device.line):
        if not is_reference(device.driver):
            message = f"the driver '{device.driver}' of '{device.name}' is one of a simulation."
            hint = "To drive a real robot write 'file.py:Class', a Sensor or Actuator of your own."
            raise InputError(Fault(message, hint=hint))
        cls = _class(catalog, robot, device)
        if not issubclass(cls, kind):
            name = kind.__name__
            raise InputError(f"'{device.driver}' of '{device.name}' is no {name}: extend rocs_bt.{name}.")
    return _driver(cls, "host", robot, device)


def make_hardware(catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec, host: Any) -> Any:
    """A device on hardware, called with its name, the host and its keys.

    Raises:
        InputError: As `hardware_driver`, or the constructor raised.
        DeviceError: The constructor cannot reach the device.
    """
    driver = hardware_driver(catalog, robot, device)
    with located_at(robot.file, device.line), driver.running(DeviceError):
        return driver.make(device.name, host, **driver.parameters)


def make_isolated(catalog: Catalog, robot: RobotSpec, actuator: ActuatorSpec) -> IsolatedActuator:
    """The link to an actuator on hardware whose device is made in a process of its own.

    Raises:
        InputError: As `make_hardware`, or this system has no such processes.
        DeviceError: The constructor cannot reach the device.
    """
    driver = hardware_driver(catalog, robot, actuator)
    file, _, cls = actuator.driver.partition(":")
    with located_at(robot.file, actuator.line):
        maker = DeviceMaker(robot.beside(file), cls, actuator.name, driver.parameters)
        return IsolatedActuator(maker, actuator.max_command_age)


def _class(catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec) -> type:
    file, _, name = device.driver.partition(":")
    with located_at(robot.file, device.line):
        return catalog.load_class(robot.beside(file), name)


def _driver(cls: type, place: str, robot: RobotSpec, device: SensorSpec | ActuatorSpec) -> Driver:
    with located_at(robot.file, device.line):
        with running_class(cls):
            declared = constructor_parameters(cls, place)
        what = f"the driver {cls.__name__} of '{device.name}'"
        return Driver(
            cls, read_arguments(declared, device.parameters, what, file=robot.file, positions=device.positions)
        )
