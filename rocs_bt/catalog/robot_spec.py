"""A robot as its robot.toml describes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..clock import Clock
from ..confine import is_file
from ..control.drive import Drive, make_drive
from ..device import Actuator
from ..event import EventSink
from ..geometry import Pose2
from ..python_content import is_reference
from ..safety import Limits, SafetyGate
from ..units import NONE, Dimension
from .values import to_si

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
        positions: Line and column of each parameter.
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
    positions: Mapping[str, tuple[int, int]] = field(default_factory=dict)

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
        positions: Line and column of each parameter.
        isolated: Whether the device lives in a process of its own; on hardware only.
    """

    name: str
    driver: str
    limits: Limits
    max_command_age: float = 0.2
    parameters: Mapping[str, Any] = field(default_factory=dict)
    size: int | None = None
    line: int = 0
    positions: Mapping[str, tuple[int, int]] = field(default_factory=dict)
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
        return next((path for path in found if is_file(path)), found[0])

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
