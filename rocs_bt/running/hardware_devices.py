"""Devices of robot.toml on hardware: a user's classes, and the devices of packages."""

from __future__ import annotations

from collections.abc import Mapping
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
from ..catalog.registered_devices import registered_devices
from ..declare import class_fields, constructed, read_arguments, refuse_constructor
from ..devices.host import Host
from ..devices.isolated import DeviceMaker, IsolatedActuator
from ..devices.simulated import SimulatedActuator, SimulatedSensor
from ..interfaces.device import Actuator, Sensor


def hardware_driver(
    catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec
) -> tuple[type[Any], Mapping[str, Any]]:
    """Class of a user's device on hardware, and the values of its keys, SI units.

    Raises:
        InputError: The driver is for simulation only, or the class does not load, extends neither Sensor nor Actuator,
            or does not take the device's keys; lists every fault.
    """
    kind = Sensor if isinstance(device, SensorSpec) else Actuator
    with located_at(robot.file, device.line):
        if not is_reference(device.driver):
            message = f"the driver '{device.driver}' of '{device.name}' is for simulation only."
            hint = (
                "To simulate this robot: rocs-bt run SCENARIO. For a real robot write 'ros2', or 'file.py:Class', a "
                "Sensor or Actuator of your own."
            )
            raise InputError(Fault(message, hint=hint))
        cls = catalog.load_driver(robot, device)
        if not issubclass(cls, kind):
            name = kind.__name__
            raise InputError(f"'{device.driver}' of '{device.name}' does not extend rocs_bt.{name}.")
        refuse_constructor(cls, ("name", "host"), kind)
        return cls, read_arguments(class_fields(cls), device.arguments, f"the driver {cls.__name__} of '{device.name}'")


def on_hardware(catalog: Catalog, robot: RobotSpec) -> bool:
    """Whether a driver of a robot is for hardware, so that the robot cannot be simulated.

    Raises:
        InputError: The class of a user's driver does not load.
    """
    devices: list[SensorSpec | ActuatorSpec] = [*robot.sensors, *robot.actuators]
    return any(
        registered_devices(device.driver) is not None
        or (
            is_reference(device.driver)
            and not issubclass(catalog.load_driver(robot, device), (SimulatedSensor, SimulatedActuator))
        )
        for device in devices
    )


def make_sensor(catalog: Catalog, robot: RobotSpec, sensor: SensorSpec, host: Host, rate: Rate) -> Any:
    """Construct a sensor on hardware that is read at a rate; see `make_hardware`."""
    if (other := registered_devices(sensor.driver)) is None:
        return make_hardware(catalog, robot, sensor, host)
    with located_at(robot.file, sensor.line):
        return other.sensor(robot, sensor, host, rate)


def make_hardware(catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec, host: Host) -> Any:
    """Construct an actuator, or a sensor with a user's driver, with its name, the host and its keys.

    Raises:
        InputError: See `hardware_driver`; or the constructor raised an exception.
        DeviceError: The constructor cannot reach the device.
    """
    if isinstance(device, ActuatorSpec) and (other := registered_devices(device.driver)) is not None:
        with located_at(robot.file, device.line):
            return other.actuator(robot, device, False)(host)
    cls, arguments = hardware_driver(catalog, robot, device)
    with located_at(robot.file, device.line), running_class(cls, DeviceError):
        return constructed(cls, arguments, device.name, host)


def make_isolated(catalog: Catalog, robot: RobotSpec, actuator: ActuatorSpec, host: Host) -> IsolatedActuator:
    """Construct an isolated actuator: its device is constructed in a separate process.

    The host is that of its standby in this process.

    Raises:
        InputError: See `make_hardware`; or the system is not POSIX.
        DeviceError: The constructor cannot reach the device.
    """
    if (other := registered_devices(actuator.driver)) is not None:
        with located_at(robot.file, actuator.line):
            return IsolatedActuator(other.actuator(robot, actuator, True), actuator.max_command_age, host)
    cls, arguments = hardware_driver(catalog, robot, actuator)
    file, _, name = actuator.driver.partition(":")
    with located_at(robot.file, actuator.line):
        maker = DeviceMaker(robot.beside(file), name, actuator.name, arguments, bool(cls.two_owners))
        return IsolatedActuator(maker, actuator.max_command_age, host)
