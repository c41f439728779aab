"""Devices of robot.toml in simulation."""

from __future__ import annotations

from typing import Any, cast, overload

from ..base.errors import Fault, InputError, located_at
from ..catalog import ActuatorSpec, Catalog, RobotSpec, SensorSpec, is_reference, running_class
from ..catalog.registered_devices import registered_devices
from ..declare import read_values
from ..devices.simulated import SimulatedActuator, SimulatedSensor


@overload
def simulated_device(catalog: Catalog, robot: RobotSpec, device: SensorSpec) -> SimulatedSensor: ...
@overload
def simulated_device(catalog: Catalog, robot: RobotSpec, device: ActuatorSpec) -> SimulatedActuator: ...
def simulated_device(
    catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec
) -> SimulatedSensor | SimulatedActuator:
    """Device in simulation with its keys, not yet bound to a world.

    Raises:
        InputError: A user's class does not load, does not extend a simulated device, or does not take the device's
            keys; lists every fault.
    """
    if (other := registered_devices(device.driver)) is not None:
        message = f"'{device.name}' uses {other.title} and is not simulated."
        hint = "To drive the robot: rocs-bt drive. To simulate, name the robot that this one is based on."
        raise InputError(Fault(message, robot.file, device.line, hint=hint))
    if not is_reference(device.driver):
        return cast("SimulatedSensor | SimulatedActuator", device.parameters)
    wanted: Any = SimulatedSensor if isinstance(device, SensorSpec) else SimulatedActuator
    cls = catalog.load_driver(robot, device)
    if not issubclass(cls, wanted):
        raise InputError(
            Fault(
                f"the driver '{cls.__name__}' of '{device.name}' is for real robots, and this one is simulated.",
                robot.file,
                device.line,
                hint=f"To drive a real robot: rocs-bt drive SCENARIO. To simulate this one extend "
                f"rocs_bt.devices.mujoco.{wanted.__name__.replace('Simulated', 'Mujoco')}.",
            )
        )
    with located_at(robot.file, device.line), running_class(cls):
        return read_values(cls, device.arguments, f"the driver {cls.__name__} of '{device.name}'")
