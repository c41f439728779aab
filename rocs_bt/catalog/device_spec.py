"""The tables `[[sensor]]` and `[[actuator]]` of a robot.toml."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Annotated, Any, cast

import numpy as np

from ..base.clock import Clock
from ..base.errors import Fault, InputError, did_you_mean
from ..base.geometry import Pose2
from ..base.python_content import is_reference
from ..base.toml_table import KnownKey, Table
from ..base.units import FREQUENCY, NOT_NEGATIVE, TIME, Bounds, Dimension, parse_quantity, parse_unit
from ..declare import (
    Content,
    InUnit,
    Keys,
    Open,
    ReadBy,
    Scope,
    SetByPrograms,
    TableKind,
    Value,
    Wrong,
    given_of,
    location_of,
    read,
)
from ..devices.simulated import DEVICES as SIMULATED
from ..devices.simulated import Position, declared_keys
from ..event import EventSink
from ..interfaces.actuator_limits import ActuatorLimits
from ..interfaces.device import Actuator
from ..interfaces.safety_gate import Landing, SafetyGate
from .marks import Coordinate, Name, PoseKeys

_NUMBER = re.compile(r"\s*[+-]?(\d|\.\d|inf\b)")
_LIMIT = Annotated[float, InUnit("unit")]
_AGE = Annotated[float, TIME, Bounds(0.0, infinite=True)]

_FAULTS = {"latency": "s", "drop_out": "", "missing_echo": "", "sweep": "s", "odometry": "", "slip": ""}
"""Unit of each fault of a device in the simulation."""

_POSE_FAULTS = {"position": {"drift": "m", "jump": "m"}, "orientation": {"drift": "rad", "jump": "rad"}}
"""Faults with a unit of their own, by driver."""

DeviceKeys = Value | Open
"""Keys of a device: of a shipped one, an object of their declared class; of a user's, as in the file."""


def _device_keys(kind: str, table: Table, done: Mapping[str, Any]) -> DeviceKeys:
    """Keys of a device; those of a user's are checked when its class is loaded, since no code runs here."""
    driver = done["driver"]
    declared = None if is_reference(driver) else declared_keys(driver, kind)
    if declared is not None:
        return read(declared, table, kind=TableKind(f"driver '{driver}'", Value))
    if any(driver in shipped for shipped in SIMULATED.values()):
        hint = did_you_mean(driver, SIMULATED[kind], "The simulation")
        table.fault("driver", f"'{driver}' is no driver of {kind}s.", hint)
    own = {key: value for key, value in table.data.items() if key not in table.known}
    table.known.update(dict.fromkeys(own, KnownKey()))
    return Open.of(table, own)


def _to_si(value: Any) -> Any:
    """Quantity in a TOML value as a number in SI units; other values are returned unchanged."""
    return parse_quantity(value).value if isinstance(value, str) and _NUMBER.match(value) else value


class MountKeys(PoseKeys):
    """Keys of the pose of a sensor, body frame."""

    x: Coordinate = 0.0
    y: Coordinate = 0.0


class BlockSpec(Value):
    """Table of a device or block of a robot.

    Attributes:
        name: Name of the block, or of the device and its node in the knowledge graph.
    """

    name: Name

    @property
    def line(self) -> int:
        """Line of the table in its file; 0 if a program has made it."""
        return location_of(self).line


class DeviceSpec(BlockSpec):
    """What `[[sensor]]` and `[[actuator]]` tables have in common.

    Attributes:
        driver: Name of the class of the device, or `file.py:Class` beside robot.toml.
        unit: Unit of the values.
        parameters: Keys of a shipped device, as an object of their declared class; those of a user's, unconverted.
    """

    driver: Annotated[str, Content("driver")]
    unit: str = "1"

    parameters: DeviceKeys

    def _check(self) -> Iterator[Wrong]:
        """Fault of the unit."""
        try:
            parse_unit(self.unit)
        except InputError as error:
            yield from (Wrong("unit", fault.message, fault.hint) for fault in error.faults)

    @property
    def dimension(self) -> Dimension:
        """Physical dimension of the values."""
        return parse_unit(self.unit).dimension

    @property
    def scale(self) -> float:
        """Factor from the declared unit to SI, for values that the device takes from messages."""
        return parse_unit(self.unit).value

    @property
    def arguments(self) -> dict[str, Any]:
        """Keyword arguments of the device: in SI units and without defaults for a shipped one, else unconverted."""
        return given_of(self.parameters) if isinstance(self.parameters, Value) else self.parameters

    @property
    def faults(self) -> list[str]:
        """Faults that the simulation gives a shipped device, as text, such as `sweep 0.025 s`."""
        units = {} if is_reference(self.driver) else _FAULTS | _POSE_FAULTS.get(self.driver, {})
        given = {"latency": getattr(self, "latency", 0.0), "drop_out": getattr(self, "drop_out", 0.0), **self.arguments}
        return [
            " ".join([name, *(f"{each:g}" for each in np.atleast_1d(given[name])), unit]).strip()
            for name, unit in units.items()
            if name in given and np.any(given[name])
        ]

    @property
    def size(self) -> int | None:
        """Number of values of a reading or command; None if only a user's device or a message knows it."""
        return cast("int | None", getattr(self.parameters, "size", None))


class SensorSpec(DeviceSpec):
    """One `[[sensor]]` table.

    Attributes:
        signal: Signal to which the readings are written, also shown by the sensor's node in the graph; the sensor's
            name by default.
        monitor: Name of the Monitor that reads the sensor; in the file it may be a class, for a Monitor of its own.
        rate: Rate of readings [Hz]; None for one in each control period.
        noise: Standard deviation of each value, in the SI unit of `dimension`.
        latency: Time until a reading of the simulated sensor can be read [s].
        drop_out: Probability that a reading of the simulated sensor is lost.
        max_age: Validity of a reading [s]; None for the latency and three sensor periods.
        mount: Pose of the sensor, body frame; None if not given.
        optional: Whether a robot on hardware may start before the sensor gives fresh values.
    """

    signal: str = ""
    monitor: Annotated[str, Content("monitor")]
    rate: Annotated[float, FREQUENCY, Bounds(0.01)] | None = None
    noise: Annotated[_LIMIT, NOT_NEGATIVE] = 0.0
    latency: Annotated[float, TIME, Bounds(0.0, 10.0)] = 0.0
    drop_out: Annotated[float, Bounds(0.0, 1.0)] = 0.0
    max_age: _AGE | None = None
    mount: Annotated[Pose2, Keys(MountKeys)] | None = None
    optional: bool = False
    parameters: Annotated[DeviceKeys, ReadBy(partial(_device_keys, "sensor"))] = Open()

    def __post_init__(self) -> None:
        # The object is new, so that it may still change; `__setattr__` refuses that.
        self.__dict__["signal"] = self.signal or self.name

    def validity(self, period: float) -> float:
        """Time for which a reading is valid [s], by `max_age` or the sensor's period [s]."""
        return self.latency + 3.0 * period if self.max_age is None else self.max_age

    @property
    def frame(self) -> str:
        """Frame of a pose: `continuous`, as of odometry, or `corrected`, as of a localiser (REP 105).

        Keys of a package may have a `pose_frame`. That of a user's device is continuous. It is empty in the simulation,
        where values may have noise, or the robot may turn over; but a position without noise and jumps is continuous.
        """
        given = self.parameters
        if known := getattr(given, "pose_frame", ""):
            return str(known)
        smooth = isinstance(given, Position) and not self.noise and not given.jump
        return "continuous" if smooth or is_reference(self.driver) else ""

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the sensor's node in the knowledge graph: wiring, mount and a scanner's rays and span."""
        known: dict[str, Any] = {"driver": self.driver, "signal": self.signal, "monitor": self.monitor}
        if self.mount is not None:
            known["mount"] = self.mount
        given = self.arguments
        if given.get("rays") and given.get("span"):  # a laser scanner
            known |= {name: _to_si(given[name]) for name in ("rays", "span")}
        return known


class ActuatorSpec(DeviceSpec):
    """One `[[actuator]]` table.

    Attributes:
        range: Minimum and maximum of each value, or one pair for all values; empty for an actuator of twists.
        max_change: Maximum rate of change of each value [1/s].
        max_command_age: Watchdog time [s]: the actuator goes to neutral if it gets no command for this time.
        isolated: Whether the device runs in a process of its own; on hardware only.
        limits: Range and rate of change of the commands, enforced by the safety gate.
        landing: Landing of a flying body without commands; None for other bodies and actuators.
    """

    range: tuple[tuple[_LIMIT, _LIMIT], ...] = ()
    max_change: Annotated[float, InUnit("unit", per=TIME), Bounds(0.0, above=True, infinite=True)] = math.inf
    max_command_age: Annotated[float, TIME, Bounds(1e-3)] = 0.2
    isolated: bool = False
    parameters: Annotated[DeviceKeys, ReadBy(partial(_device_keys, "actuator"))] = Open()
    limits: Annotated[ActuatorLimits, SetByPrograms()] = ActuatorLimits((-1.0,), (1.0,))
    landing: Annotated[Landing | None, SetByPrograms()] = None

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Write a range that is one pair as a list of pairs; note the fault of one that is neither."""
        if (given := table.data.get("range")) is None:
            return
        pairs = given if isinstance(given, list) and all(isinstance(pair, list) for pair in given) else [given]
        table.data["range"] = pairs
        if not pairs or any(not isinstance(pair, list) or len(pair) != 2 for pair in pairs):
            unit, table.data["range"] = table.data.get("unit", "1"), []
            hint = f'Write range = ["-1 {unit}", "1 {unit}"], or a list of such pairs, one for each value.'
            table.fault("range", f"range must be a pair [minimum, maximum], found {given!r:.80}.", hint)

    def limited(self, together: bool) -> ActuatorLimits:
        """Limits that the table declares.

        Args:
            together: Whether one factor scales all values.

        Raises:
            InputError: They are missing, or no range.
        """
        if not self.range:
            hint = f'Write the range of commands: range = ["-1 {self.dimension}", "1 {self.dimension}"].'
            raise InputError(Fault(f"the actuator '{self.name}' has no limits.", hint=hint))
        low, high = zip(*self.range, strict=True)
        return ActuatorLimits(low, high, self.max_change, together)

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


DEVICES: Mapping[str, type[DeviceSpec]] = {"sensor": SensorSpec, "actuator": ActuatorSpec}
"""Classes of devices by the name of their table."""

OVERLAID = (*DEVICES, "locomotion")
"""Tables of a robot that an agent of a scenario may override."""
