"""Check of robots: robot.toml, the MJCF model with its devices, and one trial call of each sensor and monitor.

An exception of a user's class is a fault of that class's file.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from ..agent import Agent, Controller
from ..base.errors import DeviceError, Fault, InputError, located_at, unknown
from ..base.raised import describe
from ..base.registered import load, registered
from ..catalog import ActuatorSpec, Catalog, Entry, MonitorSpec, RobotSpec, SensorSpec, is_reference, running_class
from ..catalog.registered_devices import registered_devices
from ..declare import location_of
from ..devices.mujoco import MujocoWorld, RobotInstance, SensorMount, compose_world
from ..devices.mujoco.body import hull_outline
from ..devices.simulated import SimulatedActuator, SimulatedSensor
from ..event import pack
from ..interfaces.device import Actuator, Reading, Sensor
from ..monitor import Monitor
from ..plan import Plan
from ..running import Run
from ..running.hardware_devices import hardware_driver
from ..simulation import simulated_device
from .identified import TOLERANCE, identified_faults
from .stub_agent import stub_agent


def check_robot(entry: Entry, catalog: Catalog, run: Run | None = None) -> Iterable[Fault]:
    """Check a robot: its file, its user drivers, its model, and its blocks.

    The devices and blocks of a prepared `run` were built and tried, so they are not tried again.
    """
    robot = catalog.load_robot(str(entry.path))
    own, built = not robot.code or catalog.code, run is not None and run.prepared and _agent_with(robot, run)
    if own:
        yield from driver_faults(robot, catalog)
    yield from _registered_faults(robot)
    sensors: dict[str, Sensor] = {}
    if run is not None and built:
        yield from _outline_faults(robot, run.world.world, built)
    else:
        sensors = yield from check_model(robot, catalog)
    known = [rules.name for rules in catalog.list("rules")]
    for name, thresholds in robot.thresholds.items():
        if name not in known:
            yield unknown("rule file", name, known).at(*location_of(thresholds))
    if not own:
        return
    yield from identified_faults(robot, catalog)
    if built:
        return
    try:
        agent = stub_agent(robot, catalog.load_class, Controller(build=Plan.idle, schema=catalog.load_schema()))
    except InputError as error:
        yield from error.at(robot.file).faults
    else:
        yield from trial_faults(agent, robot, sensors)


def _agent_with(robot: RobotSpec, run: Run) -> str:
    """Name of an agent in a run that has this robot; empty if none has, or if no code may run."""
    agents = [agent.name for agent in run.agents if run.world.robots[agent.name].file == robot.file]
    return agents[0] if agents and run.catalog.code else ""


def check_world(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """Check that a world compiles."""
    compose_world(entry.path, [], within=catalog.roots)
    return ()


def check_model(robot: RobotSpec, catalog: Catalog) -> Generator[Fault, None, dict[str, Sensor]]:
    """Check that a robot's model compiles and has its devices' elements; returns the sensors without faults.

    If the project's code may run, user drivers for MuJoCo are constructed too, each in a separate world.
    """
    if robot.model is None:
        return {}
    shipped = [(s, s.parameters) for s in robot.sensors if isinstance(s.parameters, SimulatedSensor)]
    try:
        world = _world(catalog, robot, robot.model, shipped)
    except InputError as error:
        yield from error.at(robot.model).faults
        return {}
    if robot.body.ground_contact is not None:
        try:
            world.allow_ground_contact(_NAME, robot.body.ground_contact)
        except InputError as error:
            yield from error.at(robot.file).faults
    yield from _outline_faults(robot, world, _NAME)
    made: dict[str, Sensor] = {}
    devices: list[SensorSpec | ActuatorSpec] = [*robot.sensors, *robot.actuators]
    for device in devices:
        try:
            simulated = _device(catalog, robot, device)
        except InputError:
            continue  # reported by driver_faults
        if simulated is None:
            continue
        try:
            own = is_reference(device.driver) and isinstance(simulated, SimulatedSensor)
            where = _world(catalog, robot, robot.model, [(device, simulated)]) if own else world
            with located_at(robot.file, device.line), running_class(type(simulated)):
                bound = simulated.bind(device.name, where, _NAME)
                if isinstance(bound, Sensor):
                    made[device.name] = bound
                else:
                    robot.check_twists(bound)
        except InputError as error:
            yield from error.at(robot.file, device.line).faults
    return made


_NAME, _SIMULATED = "R1", (SimulatedSensor, SimulatedActuator)


def _outline_faults(robot: RobotSpec, world: MujocoWorld, name: str) -> Iterator[Fault]:
    """Compare `[body]` with the outline of the model's hull, which collides."""
    # A real robot can have another size than the simulated one on which it is based.
    if any(device.driver in registered("rocs_bt.devices") for device in (*robot.sensors, *robot.actuators)):
        return
    outline = hull_outline(world.model, world.robots[name].hull)
    for key, declared, along in (("length", robot.body.length, 0), ("width", robot.body.width, 1)):
        places = [point[along] for point in outline]
        size = max(places, default=0.0) - min(places, default=0.0)
        if abs(declared - size) > TOLERANCE * size > 0.0:  # never for NaN
            message = f"{key} is {declared:.3g} m, but the hull of the model has {size:.3g} m"
            harm = "paths lead too near to obstacles." if declared < size else "paths avoid gaps that are wide enough."
            hint = f'Write {key} = "{size:.3g} m", or correct the geom `hull`.'
            yield Fault(f"{message}: {harm}", *location_of(robot, "body", key), hint, warning=True)


def _device(
    catalog: Catalog, robot: RobotSpec, device: SensorSpec | ActuatorSpec
) -> SimulatedSensor | SimulatedActuator | None:
    """Simulated device; None for one of a user if no code may run. Raises InputError."""
    return None if is_reference(device.driver) and not catalog.code else simulated_device(catalog, robot, device)


def _world(
    catalog: Catalog, robot: RobotSpec, model: Path, sensors: Iterable[tuple[SensorSpec | ActuatorSpec, Any]]
) -> MujocoWorld:
    """World made of the robot's model alone, which suffices to compile it."""
    mounts = [SensorMount(s.name, d, robot.file, s.line, partial(running_class, type(d))) for s, d in sensors]
    return compose_world(model, [RobotInstance(_NAME, model, mounts)], within=catalog.roots)


def driver_faults(robot: RobotSpec, catalog: Catalog) -> Iterator[Fault]:
    """Check a robot's user drivers without instantiating them: class, constructor and parameters."""
    devices: list[SensorSpec | ActuatorSpec] = [*robot.sensors, *robot.actuators]
    for device in devices:
        if not is_reference(device.driver):
            continue
        file, _, name = device.driver.partition(":")
        try:
            cls = catalog.load_class(robot.beside(file), name)
            simulated = issubclass(cls, _SIMULATED) or not issubclass(cls, (Sensor, Actuator))
            (simulated_device if simulated else hardware_driver)(catalog, robot, device)
        except InputError as error:
            yield from error.at(robot.file, device.line).faults
        else:
            if not simulated and isinstance(device, ActuatorSpec):
                yield from _not_isolated(robot, device)


def _registered_faults(robot: RobotSpec) -> Iterator[Fault]:
    """Check the devices with drivers of packages, by the checks that these register."""
    devices: list[SensorSpec | ActuatorSpec] = [*robot.sensors, *robot.actuators]
    for device in devices:
        if isinstance(device, ActuatorSpec) and device.driver in registered("rocs_bt.devices"):
            yield from _not_isolated(robot, device)
    for name in sorted(registered("rocs_bt.checks").keys() & {device.driver for device in devices}):
        yield from load("rocs_bt.checks", name)(robot)


def _not_isolated(robot: RobotSpec, actuator: ActuatorSpec) -> Iterator[Fault]:
    """Warn of an actuator on hardware that no other process stops, unless the robot follows a simulator's clock."""
    devices = registered_devices(actuator.driver)
    if not actuator.isolated and (devices is None or not devices.simulated(robot)):
        message = f"nothing sends neutral to '{actuator.name}' if this program hangs, is stopped or killed."
        hint = "Write isolated = true, unless only one program can open the line and it also carries the sensors."
        yield Fault(message, robot.file, actuator.line, hint=hint, warning=True)


def trial_faults(agent: Agent, robot: RobotSpec, sensors: Mapping[str, Sensor]) -> Iterator[Fault]:
    """Read every sensor once and let every monitor interpret the readings; yields the faults.

    Monitors that need a missing sensor are skipped.
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
    """Read a sensor: the reading by the sensor's name, or {} if the device refuses; raises InputError."""
    with _trying(spec, robot, sensor):
        try:
            reading = sensor.read()
        except DeviceError:  # allowed: its signals are then invalid
            return {}
        pack(reading.values)  # raises for values that are not numbers, as in a run
        return {spec.name: reading}


@contextmanager
def _trying(spec: SensorSpec | MonitorSpec, robot: RobotSpec, block: Sensor | Monitor) -> Iterator[None]:
    """Convert exceptions in the context to faults: at the line of a user's class, else at the table in robot.toml."""
    with located_at(robot.file, spec.line):
        try:
            with running_class(type(block)):
                yield
        except InputError:
            raise
        except Exception as error:  # a user's class may raise anything; it is reported as a fault of the robot
            what = f"{type(block).__name__} '{spec.name}' cannot use the readings of its sensors"
            raise InputError(f"{what}: {describe(error)}.") from error
