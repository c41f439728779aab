"""robot.toml: who acts. The table of a robot's devices and of the blocks that they feed (docs/architecture.md)."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..analyze import ANALYZERS
from ..clock import Clock
from ..control.drive import DRIVES, Drive, make_drive
from ..device import Actuator
from ..document import Table
from ..errors import InputError, did_you_mean
from ..event import EventSink
from ..geometry import Pose2
from ..monitor import MONITORS
from ..python_content import classes_in, is_reference
from ..safety import Limits, SafetyGate
from ..units import ANGLE, FREQUENCY, LENGTH, NONE, SPEED, TIME, Dimension, parse_unit
from .inherit import DEVICE_KEYS, FindBase, no_base, read_inheriting
from .limits import actuator_limits, check_braking, drive_limits
from .values import drive_parameters, driver_parameters, free_parameters, given_name, to_si

FORMAT = "robot/1"

_NO_DRIVE_NUMBERS = ("wheel_radius", "wheel_delay", "wheel_lag")  # of [drive]: the driver's, and the follower's


@dataclass(frozen=True)
class DriveSpec:
    """The `[drive]` table.

    Attributes:
        kind: The kind of drive, such as `differential`.
        actuator: The actuator that takes the wheel rim speeds.
        parameters: Its numbers, in SI units.
    """

    kind: str
    actuator: str
    parameters: Mapping[str, Any]


@dataclass(frozen=True)
class SensorSpec:
    """One `[[sensor]]` table.

    Attributes:
        name: The sensor's node in the knowledge graph.
        driver: The driver that makes it, or `file.py:Class` beside robot.toml.
        signal: The signal that its readings become, which its node in the graph shows live; its own name by default.
        monitor: The name of the Monitor that reads it; always one of the robot's `monitors`.
        rate: Readings per second [1/s]; None for one in each control period.
        noise: Standard deviation of each value, in the SI unit of `dimension`.
        dimension: What its values are.
        max_age: How long a reading stays valid [s]; None for three of its periods.
        mount: Where it sits and looks, in the body frame; None where nothing asks.
        parameters: Arguments of the driver: in SI units for a shipped one, as the file has them for a user's own.
        size: How many values a reading has; None where only a user's own driver knows.
        line: Where its table stands in the file.
        places: Line and column of each parameter.
    """

    name: str
    driver: str
    signal: str
    monitor: str
    rate: float | None = None
    noise: float = 0.0
    dimension: Dimension = NONE
    max_age: float | None = None
    mount: Pose2 | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    size: int | None = None
    line: int = 0
    places: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    @property
    def attributes(self) -> dict[str, Any]:
        """What the knowledge graph says of it: its wiring, and as far as robot.toml tells, how it looks."""
        told: dict[str, Any] = {"driver": self.driver, "signal": self.signal, "monitor": self.monitor}
        if self.mount is not None:
            told["mount"] = self.mount
        if {"rays", "span"} <= self.parameters.keys():  # it is a scanner
            told |= {name: to_si(self.parameters[name]) for name in ("rays", "span")}
        return told


@dataclass(frozen=True)
class MonitorSpec:
    """One `[[monitor]]` table, or the Monitor that a sensor names by its class alone.

    Attributes:
        name: The block's name.
        cls: The class's name in the table of monitors, or `file.py:Class` beside robot.toml.
        sensors: The sensors that it interprets.
        parameters: What the class takes, in SI units; sub-tables are dicts.
        line: Where its table stands in the file.
    """

    name: str
    cls: str
    sensors: tuple[str, ...]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0


@dataclass(frozen=True)
class AnalyzeSpec:
    """One `[[analyze]]` table.

    Attributes:
        name: The block's name.
        cls: The class's name in the table of analysers, or `file.py:Class` beside robot.toml.
        monitors: The Monitors that it listens to.
        parameters: What the class takes, in SI units.
        line: Where its table stands in the file.
    """

    name: str
    cls: str
    monitors: tuple[str, ...]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0


@dataclass(frozen=True)
class ActuatorSpec:
    """One `[[actuator]]` table.

    Attributes:
        name: The actuator's node in the knowledge graph.
        driver: The driver that makes it, or `file.py:Class` beside robot.toml.
        limits: Range and rate of change of its commands, which the safety gate keeps.
        max_command_age: The longest silence after which it goes to neutral [s].
        parameters: Arguments of the driver: in SI units for a shipped one, as the file has them for a user's own.
        size: How many values a command has; None where only a user's own driver knows.
        line: Where its table stands in the file.
        places: Line and column of each parameter.
        isolated: Whether the device lives in a process of its own; on hardware only.
    """

    name: str
    driver: str
    limits: Limits
    max_command_age: float = 0.2
    parameters: Mapping[str, Any] = field(default_factory=dict)
    size: int | None = None
    line: int = 0
    places: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    isolated: bool = False

    def guard(
        self, device: Actuator, clock: Clock, period: float, sink: EventSink | None = None, agent: str = ""
    ) -> SafetyGate:
        """The device behind this actuator's limits and watchdog.

        Args:
            device: The device; the caller must not keep it.
            clock: Source of time.
            period: Control period [s].
            sink: Receives the gate's events.
            agent: Name of the agent, for these events.

        Raises:
            InputError: The range has bounds for another number of values than the device takes.
        """
        return SafetyGate(
            device, clock, self.limits, period=period, max_age=self.max_command_age, sink=sink, agent=agent
        )


@dataclass(frozen=True)
class RobotSpec:
    """A robot, as its folder describes it.

    Attributes:
        name: Its folder's name.
        file: Its robot.toml.
        doc: One sentence for people.
        model: Its MJCF file; None for a robot without a body in simulation.
        drive: How it moves.
        length: Of its outline, along x [m]; NaN where robot.toml does not say.
        width: Of its outline, along y [m]; NaN where robot.toml does not say.
        sensors, monitors, analyzers, actuators: Its wiring; the agent builds exactly this.
        bases: The robot.toml files that its own is based on, the nearest first.
        thresholds: Its own values of named thresholds, as they are written, with line and column, by rule file.
    """

    name: str
    file: Path
    doc: str
    model: Path | None
    drive: DriveSpec
    length: float
    width: float
    sensors: tuple[SensorSpec, ...]
    monitors: tuple[MonitorSpec, ...]
    analyzers: tuple[AnalyzeSpec, ...]
    actuators: tuple[ActuatorSpec, ...]
    bases: tuple[Path, ...] = ()
    thresholds: Mapping[str, Mapping[str, tuple[Any, int, int]]] = field(default_factory=dict)

    def beside(self, name: str) -> Path:
        """A file that robot.toml names: beside it, or else beside one that it is based on."""
        found = [file.parent / name for file in (self.file, *self.bases)]
        return next((path for path in found if path.is_file()), found[0])

    @property
    def code(self) -> tuple[Path, ...]:
        """The Python files that it names, each once."""
        names = (
            *(s.driver for s in self.sensors),
            *(m.cls for m in self.monitors),
            *(a.cls for a in self.analyzers),
            *(a.driver for a in self.actuators),
        )
        return tuple(dict.fromkeys(self.beside(n.partition(":")[0]) for n in names if is_reference(n)))


def robot_drive(spec: DriveSpec) -> Drive:
    """The kinematics that robot.toml's `[drive]` describes.

    Raises:
        InputError: No such kind, or a number is missing or wrong.
    """
    return make_drive(spec.kind, **{k: v for k, v in spec.parameters.items() if k not in _NO_DRIVE_NUMBERS})


def command_size(robot: RobotSpec, actuator: ActuatorSpec) -> int:
    """Number of values of an actuator's command, where no device tells it: the driver's, the drive's or the range's."""
    if actuator.size is not None:
        return actuator.size
    return len(robot_drive(robot.drive).wheels) if actuator.name == robot.drive.actuator else len(actuator.limits.low)


def load_robot(file: Path, find_base: FindBase = no_base) -> RobotSpec:
    """Read a robot.toml; what is wrong in it is told all at once.

    Args:
        file: The robot.toml.
        find_base: The robot.toml of the robot that a `base` names.

    Raises:
        InputError: With every fault, each at its line.
    """
    root = read_inheriting(file, find_base)
    root.choice("format", (FORMAT,))
    doc = root.text("doc", "")
    model = _model(root)
    body = root.table("body")
    length = body.quantity("length", LENGTH, math.nan, low=0.0)
    width = body.quantity("width", LENGTH, math.nan, low=0.0)
    sensor_tables, monitor_tables, actuator_tables = (root.tables(key) for key in ("sensor", "monitor", "actuator"))
    _unique([*sensor_tables, *actuator_tables])  # nodes of one graph
    sensors, made = _wire_sensors(sensor_tables, [_sensor(t) for t in sensor_tables], monitor_tables)
    monitors = (*made, *_wire_monitors(monitor_tables, sensors))
    analyzers = tuple(_analyze(t, monitors) for t in _unique(root.tables("analyze")))
    drive_table = root.table("drive", optional=False)
    wheels = drive_table.text("actuator", "wheels")
    actuators = tuple(_actuator(t, wheels) for t in actuator_tables)
    drive = _drive(drive_table, wheels, actuators, monitor_tables)
    thresholds = {
        rules: {name: (own.raw(name), *own.place(name)) for name in own.keys()}  # noqa: SIM118 - a Table's keys are free
        for rules, own in root.named_tables("rules").items()
    }
    root.done()
    name, wiring = file.parent.name, (sensors, monitors, analyzers, actuators)
    return RobotSpec(name, file, doc, model, drive, length, width, *wiring, bases=root.bases, thresholds=thresholds)


def _model(root: Table) -> Path | None:
    if "model" not in root:
        return None
    named = root.text("model")
    model = root.beside(named)
    if _beside(root, "model", named) and not model.is_file():
        root.fault("model", f"there is no model file '{model.name}' beside robot.toml.")
    return model


def _beside(table: Table, key: str, named: str) -> bool:
    """Whether a file is in the robot's folder, which is all that a robot is made of and all that its hash covers."""
    path = table.beside(named)
    if any(path.resolve().is_relative_to(file.parent.resolve()) for file in (table.file, *table.bases)):
        return True
    table.fault(key, f"'{named}' is not in the robot's folder.", "Put what the robot is made of beside robot.toml.")
    return False


def _drive(table: Table, wheels: str, actuators: Sequence[ActuatorSpec], monitors: Sequence[Table]) -> DriveSpec:
    kind, before = table.choice("kind", DRIVES), len(table.faults)
    numbers = drive_parameters(table, kind)
    actuator = next((a for a in actuators if a.name == wheels), None)
    if actuator is None:
        _unknown(table, "actuator", wheels, [a.name for a in actuators], "actuator")
    else:
        ramp = actuator.parameters.get("max_acceleration", math.inf)
        ramp = ramp if actuator.driver == "velocity" else math.inf
        check_braking(monitors, min(actuator.limits.max_change, ramp))
        numbers |= drive_limits(table, numbers, actuator.limits, ramp)
    spec = DriveSpec(kind, wheels, numbers)
    if kind in DRIVES and len(table.faults) == before:
        try:
            robot_drive(spec)
        except InputError as error:
            table.adopt(None, error)
    return spec


def _sensor(table: Table) -> SensorSpec:
    name = given_name(table)
    dimension = _dimension(table)
    driver = _class(table, "driver")
    parameters, size = driver_parameters(table, DEVICE_KEYS["sensor"], driver)
    return SensorSpec(
        name=name,
        driver=driver,
        signal=table.text("signal", name),
        monitor=table.text("monitor"),
        rate=table.quantity("rate", FREQUENCY, low=0.01) if "rate" in table else None,
        noise=table.quantity("noise", dimension, 0.0, low=0.0),
        dimension=dimension,
        max_age=table.quantity("max_age", TIME, low=0.0, high=math.inf) if "max_age" in table else None,
        mount=_mount(table.table("mount")) if "mount" in table else None,
        parameters=parameters,
        size=size,
        line=table.place()[0],
        places={key: table.place(key) for key in parameters},
    )


def _mount(table: Table) -> Pose2:
    return Pose2(table.quantity("x", LENGTH, 0.0), table.quantity("y", LENGTH, 0.0), table.quantity("yaw", ANGLE, 0.0))


def _dimension(table: Table, default: str = "1") -> Dimension:
    try:
        return parse_unit(table.text("unit", default)).dimension
    except InputError as error:
        table.adopt("unit", error)
        return NONE


def _wire_sensors(
    tables: Sequence[Table], sensors: Sequence[SensorSpec], declared: Sequence[Table]
) -> tuple[tuple[SensorSpec, ...], list[MonitorSpec]]:
    """Each sensor with the name of its Monitor, and the Monitors that are made from a class's name alone."""
    names = {str(t.raw("name", "")) for t in declared}
    wired, made = [], []
    for table, sensor in zip(tables, sensors, strict=True):
        if sensor.monitor in names:
            wired.append(sensor)
            continue
        _class(table, "monitor", MONITORS)
        if sensor.name in names:
            table.fault("monitor", f"a [[monitor]] is named '{sensor.name}' too.", "Name it here, or rename it.")
        made.append(MonitorSpec(sensor.name, sensor.monitor, (sensor.name,), line=sensor.line))
        wired.append(replace(sensor, monitor=sensor.name))
    return tuple(wired), made


def _wire_monitors(tables: Sequence[Table], sensors: Sequence[SensorSpec]) -> Iterator[MonitorSpec]:
    """Each `[[monitor]]` with the sensors that it lists or that name it."""
    existing = [s.name for s in sensors]
    for table in _unique(tables):
        name, listed = given_name(table), table.texts("sensors", [])
        for sensor in listed:
            if sensor not in existing:
                _unknown(table, "sensors", sensor, existing, "sensor")
        listed += [s.name for s in sensors if s.monitor == name and s.name not in listed]
        if not listed:
            table.fault(None, f"no sensor feeds the monitor '{name}'.", "List some: sensors = [...].")
        parameters = free_parameters(table, ("name", "class", "sensors"))
        yield MonitorSpec(name, _class(table, "class", MONITORS), tuple(listed), parameters, table.place()[0])


def _analyze(table: Table, monitors: Sequence[MonitorSpec]) -> AnalyzeSpec:
    names = [m.name for m in monitors]
    wanted = table.texts("monitors")
    for name in wanted:
        if name not in names:
            _unknown(table, "monitors", name, names, "monitor")
    known = ("name", "class", "monitors")
    cls = _class(table, "class", ANALYZERS)
    return AnalyzeSpec(given_name(table), cls, tuple(wanted), free_parameters(table, known), table.place()[0])


def _actuator(table: Table, wheels: str) -> ActuatorSpec:
    moves = table.raw("name", None) == wheels
    dimension = _dimension(table, "m/s" if moves else "1")
    if moves and dimension != SPEED:
        table.fault("unit", f"the wheels' actuator takes speeds, found '{table.raw('unit')}'.", 'Write unit = "m/s".')
    limits = actuator_limits(table, dimension, together=moves)
    age = table.quantity("max_command_age", TIME, 0.2, low=1e-3)
    driver = _class(table, "driver")
    parameters, size = driver_parameters(table, DEVICE_KEYS["actuator"], driver)
    places = {key: table.place(key) for key in parameters}
    line, isolated = table.place()[0], table.flag("isolated", False)
    return ActuatorSpec(given_name(table), driver, limits, age, parameters, size, line, places, isolated)


def _class(table: Table, key: str, shipped: Collection[str] | None = None) -> str:
    """A name from a table of ours, or `file.py:Class`, whose file must stand beside this one and have the class."""
    name = table.text(key)
    if is_reference(name):
        file, _, cls = name.partition(":")
        if not _beside(table, key, file):
            return name
        try:
            classes = classes_in(table.beside(file))
        except InputError as error:
            table.adopt(key, error)
        else:
            if cls not in classes:
                table.fault(key, f"'{file}' has no class '{cls}'.", did_you_mean(cls, classes, f"'{file}'"))
    elif shipped is not None and name and name not in shipped:
        hint = did_you_mean(name, shipped, "The table")
        what = "monitor" if key == "monitor" else f"{table.key[0]} class"
        table.fault(key, f"no {what} is named '{name}'.", f"{hint} Or name your own: 'file.py:Class'.")
    return name


def _unknown(table: Table, key: str, name: str, known: Sequence[str], what: str) -> None:
    table.fault(key, f"no {what} of this robot is named '{name}'.", did_you_mean(name, known, "The robot"))


def _unique(tables: Sequence[Table]) -> Sequence[Table]:
    """The same tables; notes a fault at each whose name an earlier one has."""
    seen: dict[str, str | int] = {}
    for table in tables:
        name = str(table.raw("name", ""))
        if name and name in seen:
            table.fault("name", f"another [[{seen[name]}]] is named '{name}'.", "Give each its own name.")
        seen.setdefault(name, table.key[0])
    return tables
