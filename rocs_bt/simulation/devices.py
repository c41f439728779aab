"""Drivers of the devices in robot.toml: shipped drivers by name, user drivers by class and constructor arguments."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any

from ..base.clock import Rate
from ..base.errors import DeviceError, Fault, InputError, located_at
from ..catalog import (
    ActuatorSpec,
    Catalog,
    RobotSpec,
    SensorSpec,
    is_reference,
    running_class,
)
from ..catalog.driver import registered_driver
from ..declare import constructor_fields, read_arguments
from ..drivers.host import Host
from ..drivers.isolated import DeviceMaker, IsolatedActuator
from ..drivers.mujoco import MujocoActuator, MujocoSensor
from ..interfaces.device import Actuator, Sensor


@dataclass(frozen=True)
class Driver:
    """Driver of one device.

    Attributes:
        make: Name of a shipped driver, or a user's class.
        parameters: Keyword arguments, SI units.
    """

    make: Any
    parameters: Mapping[str, Any]

    def running(self, *passing: type[Exception]) -> AbstractContextManager[None]:
        """Context that converts exceptions of a user's class to faults of its file; InputErrors pass unchanged."""
        return running_class(self.make, *passing) if isinstance(self.make, type) else nullcontext()


def mujoco_driver(catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec) -> Driver:
    """Driver of a device in simulation.

    Raises:
        InputError: A user's class does not load, does not extend a MuJoCo driver, or does not take the device's keys;
            lists every fault.
    """
    if (other := registered_driver(device.driver)) is not None:
        message = f"'{device.name}' uses {other.title} and is not simulated."
        hint = "To drive the robot: rocs-bt drive. To simulate, name the robot that this one is based on."
        raise InputError(Fault(message, robot.file, device.line, hint=hint))
    if not is_reference(device.driver):
        return Driver(device.driver, device.arguments)
    wanted = MujocoSensor if isinstance(device, SensorSpec) else MujocoActuator
    cls = _class(catalog, robot, device)
    if not issubclass(cls, wanted):
        raise InputError(
            Fault(
                f"the driver '{cls.__name__}' of '{device.name}' is not a MuJoCo driver.",
                robot.file,
                device.line,
                hint=f"To drive a real robot: rocs-bt drive SCENARIO. To simulate this one extend "
                f"rocs_bt.drivers.mujoco.{wanted.__name__}.",
            )
        )
    return _driver(cls, "mount", robot, device)


def hardware_driver(catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec) -> Driver:
    """Driver of a device on hardware: a user's class, or a registered one, by its name.

    Raises:
        InputError: The driver is for simulation only, or the class does not load, extends neither Sensor nor Actuator,
            or does not take the device's keys; lists every fault.
    """
    kind = Sensor if isinstance(device, SensorSpec) else Actuator
    if registered_driver(device.driver) is not None:
        return Driver(device.driver, device.arguments)
    with located_at(robot.file, device.line):
        if not is_reference(device.driver):
            message = f"the driver '{device.driver}' of '{device.name}' is for simulation only."
            hint = (
                "To simulate this robot: rocs-bt run SCENARIO. For a real robot write 'ros2', or 'file.py:Class', a "
                "Sensor or Actuator of your own."
            )
            raise InputError(Fault(message, hint=hint))
        cls = _class(catalog, robot, device)
        if not issubclass(cls, kind):
            name = kind.__name__
            raise InputError(f"'{device.driver}' of '{device.name}' does not extend rocs_bt.{name}.")
    return _driver(cls, "host", robot, device)


def on_hardware(catalog: Catalog, robot: RobotSpec) -> bool:
    """Whether a driver of a robot is for hardware, so that the robot cannot be simulated.

    Raises:
        InputError: The class of a user's driver does not load.
    """
    devices: list[SensorSpec | ActuatorSpec] = [*robot.sensors, *robot.actuators]
    return any(
        registered_driver(device.driver) is not None
        or (
            is_reference(device.driver)
            and not issubclass(_class(catalog, robot, device), (MujocoSensor, MujocoActuator))
        )
        for device in devices
    )


def make_sensor(catalog: Catalog, robot: RobotSpec, sensor: SensorSpec, host: Host, rate: Rate) -> Any:
    """Construct a sensor on hardware that is read at a rate; see `make_hardware`."""
    if (other := registered_driver(sensor.driver)) is None:
        return make_hardware(catalog, robot, sensor, host)
    with located_at(robot.file, sensor.line):
        return other.sensor(robot, sensor, host, rate)


def make_hardware(catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec, host: Host) -> Any:
    """Construct an actuator, or a sensor with a user's driver, with its name, the host and its keys.

    Raises:
        InputError: See `hardware_driver`; or the constructor raised an exception.
        DeviceError: The constructor cannot reach the device.
    """
    if isinstance(device, ActuatorSpec) and (other := registered_driver(device.driver)) is not None:
        with located_at(robot.file, device.line):
            return other.actuator(robot, device, False)(host)
    driver = hardware_driver(catalog, robot, device)
    with located_at(robot.file, device.line), driver.running(DeviceError):
        return driver.make(device.name, host, **driver.parameters)


def make_isolated(catalog: Catalog, robot: RobotSpec, actuator: ActuatorSpec, host: Host) -> IsolatedActuator:
    """Construct an isolated actuator: its device is constructed in a separate process.

    The host is that of its standby in this process.

    Raises:
        InputError: See `make_hardware`; or the system is not POSIX.
        DeviceError: The constructor cannot reach the device.
    """
    if (other := registered_driver(actuator.driver)) is not None:
        with located_at(robot.file, actuator.line):
            return IsolatedActuator(other.actuator(robot, actuator, True), actuator.max_command_age, host)
    driver = hardware_driver(catalog, robot, actuator)
    file, _, cls = actuator.driver.partition(":")
    with located_at(robot.file, actuator.line):
        two = bool(driver.make.two_owners)
        maker = DeviceMaker(robot.beside(file), cls, actuator.name, driver.parameters, two)
        return IsolatedActuator(maker, actuator.max_command_age, host)


def _class(catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec) -> type:
    file, _, name = device.driver.partition(":")
    with located_at(robot.file, device.line):
        return catalog.load_class(robot.beside(file), name)


def _driver(cls: type, second: str, robot: RobotSpec, device: SensorSpec | ActuatorSpec) -> Driver:
    with located_at(robot.file, device.line):
        with running_class(cls):
            declared = constructor_fields(cls, ("name", second))
        what = f"the driver {cls.__name__} of '{device.name}'"
        return Driver(cls, read_arguments(declared, device.arguments, what))
