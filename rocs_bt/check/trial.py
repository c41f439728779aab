"""Trial calls of a robot's sensors and monitors: an exception of a user's own class is a fault of its file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from ..agent import Agent
from ..catalog import ActuatorSpec, Catalog, MonitorSpec, RobotSpec, SensorSpec, is_reference, running_class
from ..device import Actuator, Reading, Sensor
from ..drivers.mujoco import MujocoActuator, MujocoSensor
from ..errors import DeviceError, Fault, InputError, blame
from ..event import pack
from ..monitor import Monitor
from ..raised import describe
from ..simulation import hardware_driver, mujoco_driver


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
    with blame(robot.file, spec.line):
        try:
            with running_class(type(block)):
                yield
        except InputError:
            raise
        except Exception as error:
            what = f"{type(block).__name__} '{spec.name}' cannot use the readings of its sensors"
            raise InputError(f"{what}: {describe(error)}.") from error
