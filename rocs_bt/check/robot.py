"""Robots: robot.toml, the MJCF model that its devices name, and one trial call of each sensor and monitor.

An exception of a user's own class is a fault of its file.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from ..agent import Agent, Controller
from ..catalog import ActuatorSpec, Catalog, Entry, MonitorSpec, RobotSpec, SensorSpec, is_reference, running_class
from ..device import Actuator, Reading, Sensor
from ..drivers.mujoco import (
    MujocoActuator,
    MujocoSensor,
    MujocoWorld,
    Placed,
    SensorMount,
    compose_world,
    make_actuator,
    make_sensor,
)
from ..errors import DeviceError, Fault, InputError, located_at, unknown
from ..event import pack
from ..monitor import Monitor
from ..raised import describe
from ..simulation import Driver, hardware_driver, mujoco_driver
from .paper import idle, paper_agent


def check_robot(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """All that is wrong with a robot: its table, its own drivers, its model, and its blocks."""
    robot = catalog.load_robot(str(entry.path))
    own = not robot.code or catalog.code
    if own:
        yield from driver_faults(robot, catalog)
    sensors = yield from check_model(robot, catalog)
    known = [rules.name for rules in catalog.list("rules")]
    for name, thresholds in robot.thresholds.items():
        if name not in known:
            line = next((line for _, line, _ in thresholds.values()), 0)
            yield unknown("rule file", name, known).at(robot.file, line)
    if not own:
        return
    try:
        agent = paper_agent(robot, catalog.load_class, Controller(build=idle, schema=catalog.load_schema()))
    except InputError as error:
        yield from error.at(robot.file).faults
    else:
        yield from trial_faults(agent, robot, sensors)


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
            with located_at(robot.file, device.line), driver.running():
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


def driver_faults(robot: RobotSpec, catalog: Catalog) -> Iterator[Fault]:
    """All that is wrong with a robot's own drivers before one is made: class, constructor, keys."""
    devices: list[SensorSpec | ActuatorSpec] = [*robot.sensors, *robot.actuators]
    for device in devices:
        if not is_reference(device.driver):
            continue
        file, _, name = device.driver.partition(":")
        try:
            cls = catalog.load_class(robot.beside(file), name)
            simulated = issubclass(cls, (MujocoSensor, MujocoActuator)) or not issubclass(cls, (Sensor, Actuator))
            (mujoco_driver if simulated else hardware_driver)(catalog, robot, device)
        except InputError as error:
            yield from error.at(robot.file, device.line).faults


def trial_faults(agent: Agent, robot: RobotSpec, sensors: Mapping[str, Sensor]) -> Iterator[Fault]:
    """Read every sensor once and have every monitor interpret the readings.

    Args:
        agent: The robot's agent; the signals are written to its Knowledge.
        robot: The robot.
        sensors: The sensors by name; a monitor of a sensor that is missing here is not tried.
    """
    readings: dict[str, Reading] = {}
    for sensor in robot.sensors:
        if sensor.name in sensors:
            try:
                readings |= _read(sensor, sensors[sensor.name], robot)
            except InputError as error:
                yield from error.faults
    for spec in robot.monitors:
        monitor = next(m for m in agent.monitors if m.name == spec.name)
        if not all(name in readings for name in spec.sensors):
            continue
        try:
            with _trying(spec, robot, monitor):
                given = {name: readings[name] for name in spec.sensors}
                written = monitor.interpret(given)
                agent.knowledge.signals.update(written, monitor.stamp(given))
        except InputError as error:
            yield from error.faults


def _read(spec: SensorSpec, sensor: Sensor, robot: RobotSpec) -> dict[str, Reading]:
    """A sensor's reading by its name; none where the device refuses.

    Raises:
        InputError: It raises, or its reading is none.
    """
    with _trying(spec, robot, sensor):
        try:
            reading = sensor.read()
        except DeviceError:  # a device may refuse; its signals are invalid then
            return {}
        pack(reading.values)  # which takes nothing but numbers, as a run does
        return {spec.name: reading}


@contextmanager
def _trying(spec: SensorSpec | MonitorSpec, robot: RobotSpec, block: Sensor | Monitor) -> Iterator[None]:
    """Turn what is raised in here into a fault: of a user's own class at its line, else of the table in robot.toml.

    Raises:
        InputError: Anything was raised.
    """
    with located_at(robot.file, spec.line):
        try:
            with running_class(type(block)):
                yield
        except InputError:
            raise
        except Exception as error:
            what = f"{type(block).__name__} '{spec.name}' cannot use the readings of its sensors"
            raise InputError(f"{what}: {describe(error)}.") from error
