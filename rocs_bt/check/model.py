"""MJCF files: that they compile, and that a robot's devices find their sites and motors in them."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from pathlib import Path

from ..catalog import ActuatorSpec, Catalog, Entry, RobotSpec, SensorSpec, is_reference
from ..device import Sensor
from ..drivers.mujoco import MujocoWorld, Placed, SensorMount, compose_world, make_actuator, make_sensor
from ..errors import Fault, InputError, blame
from ..simulation import Driver, mujoco_driver


def check_world(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """That a world compiles."""
    compose_world(entry.path, [], within=catalog.roots)
    return ()


def check_model(robot: RobotSpec, catalog: Catalog) -> Generator[Fault, None, dict[str, Sensor]]:
    """That a robot's model compiles and has what its devices name.

    A user's own drivers are made too where they are MuJoCo's and code may run, each in a world of its own.

    Returns:
        The sensors that could be made, by name.
    """
    if robot.model is None:
        return {}
    shipped = [s for s in robot.sensors if not is_reference(s.driver)]
    try:
        world = _world(catalog, robot, robot.model, [(s, Driver(s.driver, s.parameters)) for s in shipped])
    except InputError as error:
        yield from error.at(robot.model).faults
        return {}
    made: dict[str, Sensor] = {}
    devices: list[SensorSpec | ActuatorSpec] = [*robot.sensors, *robot.actuators]
    for device in devices:
        try:
            driver = _driver(catalog, robot, device)
        except InputError:
            continue  # reported where the drivers themselves are checked
        if driver is None:
            continue
        try:
            own = is_reference(device.driver) and isinstance(device, SensorSpec)
            where = _world(catalog, robot, robot.model, [(device, driver)]) if own else world
            with blame(robot.file, device.line), driver.running():
                if isinstance(device, SensorSpec):
                    made[device.name] = make_sensor(where, _NAME, device.name, driver.make, driver.parameters)
                else:
                    make_actuator(where, _NAME, device.name, driver.make, driver.parameters)
        except InputError as error:
            yield from error.at(robot.file, device.line).faults
    return made


_NAME = "R1"


def _driver(catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec) -> Driver | None:
    """The driver of a device; None for a user's own where no code may run.

    Raises:
        InputError: It is none for MuJoCo, or is wrong.
    """
    if is_reference(device.driver) and not catalog.code:
        return None
    return mujoco_driver(catalog, robot, device)


def _world(
    catalog: Catalog, robot: RobotSpec, model: Path, sensors: Iterable[tuple[SensorSpec | ActuatorSpec, Driver]]
) -> MujocoWorld:
    """The model placed in itself, as any world will do to compile it."""
    mounts = [SensorMount(s.name, d.make, d.parameters, robot.file, s.line, d.running) for s, d in sensors]
    return compose_world(model, [Placed(_NAME, model, mounts)], within=catalog.roots)
