"""RobotSpec: content of a robot.toml, that is locomotion, devices and the wiring of blocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..base.clock import Clock
from ..base.errors import Fault, InputError
from ..base.files import is_file
from ..base.geometry import Pose2
from ..base.parameter import Positions
from ..base.python_content import is_reference
from ..base.units import NONE, Dimension, Quantity
from ..base.words import counted
from ..control.body_values import body_values
from ..control.locomotion import Locomotion
from ..control.locomotion_kinds import make_locomotion
from ..declare import Open, Value, given_of
from ..drivers import PositionParameters
from ..drivers.body_variant import AS_MODELLED, BodyVariant
from ..event import EventSink
from ..interfaces.device import Actuator
from ..interfaces.safety import Landing, Limits, SafetyGate
from .values import to_si


@dataclass(frozen=True)
class LocomotionSpec:
    """`[locomotion]` table: how the robot moves.

    Attributes:
        kind: Kind of locomotion, such as `differential`.
        actuator: Name of the actuator that takes the motion commands.
        parameters: Parameters for `make_locomotion`, in SI units.
    """

    kind: str
    actuator: str
    parameters: Mapping[str, Any]


DriverKeys = Value | Open
"""Keys of a device's driver: of a shipped driver, an object of their declared class; of a user's, as in the file."""


class DeviceSpec:
    """What `[[sensor]]` and `[[actuator]]` tables have in common."""

    parameters: DriverKeys

    @property
    def arguments(self) -> dict[str, Any]:
        """Keyword arguments of the driver: in SI units and without defaults for a shipped one, else unconverted."""
        return given_of(self.parameters) if isinstance(self.parameters, Value) else self.parameters

    @property
    def size(self) -> int | None:
        """Number of values of a reading or command; None if only a user's driver or a message knows it."""
        return cast("int | None", getattr(self.parameters, "size", None))


@dataclass(frozen=True)
class SensorSpec(DeviceSpec):
    """One `[[sensor]]` table.

    Attributes:
        name: Name of the sensor and of its node in the knowledge graph.
        driver: Driver's name, or `file.py:Class` beside robot.toml.
        signal: Signal to which the readings are written, also shown by the sensor's node in the graph; the sensor's
            name by default.
        monitor: Name of the Monitor that reads the sensor; always one of the robot's `monitors`.
        rate: Rate of readings [Hz]; None for one in each control period.
        noise: Standard deviation of each value, in the SI unit of `dimension`.
        latency: Time until a reading of the simulated sensor can be read [s].
        drop_out: Probability that a reading of the simulated sensor is lost.
        dimension: Physical dimension of the values.
        scale: Factor from the declared unit to SI, for values that the driver takes from messages.
        max_age: Validity of a reading [s]; None for the latency and three sensor periods.
        mount: Pose of the sensor, body frame; None if not given.
        parameters: Keys of a shipped driver, as an object of their declared class; those of a user's, unconverted.
        optional: Whether a robot on hardware may start before the sensor gives fresh values.
        line: Line of the table in the file.
    """

    name: str
    driver: str
    signal: str
    monitor: str
    rate: float | None = None
    noise: float = 0.0
    dimension: Dimension = NONE
    scale: float = 1.0
    max_age: float | None = None
    mount: Pose2 | None = None
    parameters: DriverKeys = field(default_factory=Open)
    optional: bool = False
    line: int = 0
    latency: float = 0.0
    drop_out: float = 0.0

    def validity(self, period: float) -> float:
        """Time for which a reading is valid [s], by `max_age` or the sensor's period [s]."""
        return self.latency + 3.0 * period if self.max_age is None else self.max_age

    @property
    def frame(self) -> str:
        """Frame of a pose: `continuous`, as of odometry, or `corrected`, as of a localiser (REP 105).

        That of a user's driver is continuous. It is empty in the simulation, where values may have noise, or the robot
        may turn over; but a position without noise and jumps is continuous.
        """
        if self.driver != "ros2":
            given = self.parameters
            smooth = isinstance(given, PositionParameters) and not self.noise and not given.jump
            return "continuous" if smooth or is_reference(self.driver) else ""
        kind = str(self.arguments.get("type", ""))
        transforms = kind.endswith("/TFMessage") and not str(self.arguments.get("frame", "map")).endswith("odom")
        corrected = transforms or "/PoseWithCovariance" in kind or kind.endswith("/PoseStamped")
        return "corrected" if corrected else "continuous"

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the sensor's node in the knowledge graph: wiring, mount and a scanner's rays and span."""
        known: dict[str, Any] = {"driver": self.driver, "signal": self.signal, "monitor": self.monitor}
        if self.mount is not None:
            known["mount"] = self.mount
        given = self.arguments
        if given.get("rays") and given.get("span"):  # a laser scanner
            known |= {name: to_si(given[name]) for name in ("rays", "span")}
        return known


@dataclass(frozen=True)
class MonitorSpec:
    """One `[[monitor]]` table, or the Monitor made for a sensor that names only its class.

    Attributes:
        name: Block's name.
        cls: Name of a shipped Monitor class, or `file.py:Class` beside robot.toml.
        sensors: Names of the sensors that the Monitor reads.
        parameters: Arguments of the class, unconverted; sub-tables are dicts.
        line: Line of the table in the file.
        positions: Line and column of each argument in the file; those of a sub-table are named `TABLE.NAME`.
    """

    name: str
    cls: str
    sensors: tuple[str, ...]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0
    positions: Positions = field(default_factory=dict)


@dataclass(frozen=True)
class AnalyzeSpec:
    """One `[[analyze]]` table.

    Attributes:
        name: Block's name.
        cls: Name of a shipped Analyze class, or `file.py:Class` beside robot.toml.
        monitors: Names of the Monitors that supply the signals of the Analyze block.
        parameters: Arguments of the class, unconverted.
        line: Line of the table in the file.
        positions: Line and column of each argument in the file; those of a sub-table are named `TABLE.NAME`.
    """

    name: str
    cls: str
    monitors: tuple[str, ...]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0
    positions: Positions = field(default_factory=dict)


@dataclass(frozen=True)
class ActuatorSpec(DeviceSpec):
    """One `[[actuator]]` table.

    Attributes:
        name: Name of the actuator and of its node in the knowledge graph.
        driver: Driver's name, or `file.py:Class` beside robot.toml.
        limits: Range and rate of change of the commands, enforced by the safety gate.
        max_command_age: Watchdog time [s]: the actuator goes to neutral if it gets no command for this time.
        parameters: Keys of the driver, as of a sensor.
        line: Line of the table in the file.
        isolated: Whether the device runs in a process of its own; on hardware only.
        landing: Landing of a flying body without commands; None for other bodies and actuators.
    """

    name: str
    driver: str
    limits: Limits
    max_command_age: float = 0.2
    parameters: DriverKeys = field(default_factory=Open)
    line: int = 0
    isolated: bool = False
    landing: Landing | None = None

    def guard(
        self, device: Actuator, clock: Clock, period: float, sink: EventSink | None = None, agent: str = ""
    ) -> SafetyGate:
        """Wrap a device in a safety gate with this actuator's limits and watchdog.

        Args:
            device: Device; the caller must not use it directly any more.
            clock: Source of time.
            period: Control period [s].
            sink: Sink of the gate's events.
            agent: Name of the agent, for these events.

        Raises:
            InputError: The number of bounds differs from the number of values of the device.
        """
        return SafetyGate(
            device,
            clock,
            self.limits,
            period=period,
            max_age=self.max_command_age,
            sink=sink,
            agent=agent,
            landing=self.landing,
        )


@dataclass(frozen=True)
class RobotSpec:
    """Content of a robot's folder.

    Attributes:
        name: Folder's name.
        file: The robot.toml.
        doc: One-sentence description.
        model: MJCF file; None for a robot without a body in simulation.
        locomotion: Locomotion of the robot.
        length: Length of the outline along x [m]; NaN if robot.toml omits it.
        width: Width of the outline along y [m]; NaN if robot.toml omits it.
        sensors, monitors, analyzers, actuators: Devices and blocks; the agent consists of exactly these.
        bases: The robot.toml files that this one is based on, nearest first.
        thresholds: Robot-specific values of named thresholds as written, with line and column, by rule file.
        ground_contact: Geoms of the model that may touch the ground; None for those that carry the robot in its pose.
        ros2: The `[ros2]` table; None if robot.toml has none.
        positions: Line and column of `model` and of the keys of `locomotion` and `body`, such as `body.length`.
        variant: Differences of the simulated body from its model; set by perturbations and never by a file.
    """

    name: str
    file: Path
    doc: str
    model: Path | None
    locomotion: LocomotionSpec
    length: float
    width: float
    sensors: tuple[SensorSpec, ...]
    monitors: tuple[MonitorSpec, ...]
    analyzers: tuple[AnalyzeSpec, ...]
    actuators: tuple[ActuatorSpec, ...]
    bases: tuple[Path, ...] = ()
    thresholds: Mapping[str, Mapping[str, tuple[Any, int, int]]] = field(default_factory=dict)
    ground_contact: tuple[str, ...] | None = None
    ros2: Any = None  # its registered class, as in `rocs_bt.tables`
    positions: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    variant: BodyVariant = AS_MODELLED

    def position(self, table: str, *keys: str) -> tuple[int, int]:
        """Line and column of the first of the keys that a table of robot.toml has; else of the table, or of `base`."""
        names = (*(f"{table}.{key}" for key in keys), table, "")
        return next((self.positions[name] for name in names if name in self.positions), (0, 0))

    @cached_property
    def faults(self) -> tuple[str, ...]:
        """Faults that the simulation gives the devices, such as `lidar: latency 0.1 s, drop_out 0.05`."""
        own = [(s.name, s.driver, {"latency": s.latency, "drop_out": s.drop_out, **s.arguments}) for s in self.sensors]
        devices = (*own, *((a.name, a.driver, a.arguments) for a in self.actuators))
        found = {name: _faults(driver, values) for name, driver, values in devices}
        return tuple(f"{name}: {', '.join(faults)}" for name, faults in found.items() if faults)

    @cached_property
    def values(self) -> Mapping[str, Quantity]:
        """Constants of the body that rule files may use, by the names of `control.body_values.BODY_VALUES`."""
        return body_values(robot_locomotion(self.locomotion), self.length, self.width)

    def beside(self, name: str) -> Path:
        """Path of a file that robot.toml names: in the robot's folder, else in that of the nearest base that has it."""
        found = [file.parent / name for file in (self.file, *self.bases)]
        return next((path for path in found if is_file(path)), found[0])

    def check_twists(self, device: Actuator) -> None:
        """Check that the actuator of a body without wheels takes one value for each axis of the twist.

        Args:
            device: Any actuator of the robot; those that do not move the body are ignored.

        Raises:
            InputError: The number of values differs from the number of axes.
        """
        if device.name != self.locomotion.actuator:
            return
        locomotion = robot_locomotion(self.locomotion)
        if not locomotion.wheeled and device.size != len(locomotion.values):
            axes = ", ".join(locomotion.values)
            message = f"{type(device).__name__} takes {counted(device.size, 'value')}, but the locomotion has {axes}."
            hint = "The values are in the order of the axes; an axis without a table in [locomotion] has no value."
            # Usually the first axis is not the wrong one, and it may be that of a base.
            raise InputError(Fault(message, self.file, *self.position("locomotion", "vy", "vz", "wz", "vx"), hint))

    @property
    def code(self) -> tuple[Path, ...]:
        """Python files named in robot.toml, each once."""
        names = (
            *(s.driver for s in self.sensors),
            *(m.cls for m in self.monitors),
            *(a.cls for a in self.analyzers),
            *(a.driver for a in self.actuators),
        )
        return tuple(dict.fromkeys(self.beside(n.partition(":")[0]) for n in names if is_reference(n)))


_FAULTS = {"latency": "s", "drop_out": "", "missing_echo": "", "sweep": "s", "odometry": "", "slip": ""}
"""Unit of each fault of a device in the simulation."""

_POSE_FAULTS = {"position": {"drift": "m", "jump": "m"}, "orientation": {"drift": "rad", "jump": "rad"}}
"""Faults with a unit of their own, by driver."""


def _faults(driver: str, values: Mapping[str, Any]) -> list[str]:
    """Faults of a device with a shipped driver, as text, such as `sweep 0.025 s`."""
    units = {} if is_reference(driver) else _FAULTS | _POSE_FAULTS.get(driver, {})
    return [
        " ".join([name, *(f"{each:g}" for each in np.atleast_1d(values[name])), unit]).strip()
        for name, unit in units.items()
        if name in values and np.any(values[name])
    ]


def robot_locomotion(spec: LocomotionSpec) -> Locomotion:
    """Locomotion from the `[locomotion]` table of a robot.toml.

    Raises:
        InputError: Unknown kind, or a parameter is missing or invalid.
    """
    return make_locomotion(spec.kind, **spec.parameters)


def command_size(robot: RobotSpec, actuator: ActuatorSpec) -> int:
    """Number of values of an actuator's command, from its driver, the locomotion or its range, without a device."""
    if actuator.size is not None:
        return actuator.size
    if actuator.name == robot.locomotion.actuator:
        return len(robot_locomotion(robot.locomotion).values)
    return len(actuator.limits.low)
