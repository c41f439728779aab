"""RangeMonitor: ranges of sonars or similar sensors, and the standard groups of beams that rules use."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np

from ..base.errors import Fault, InputError
from ..base.signal import Signal
from ..base.units import LENGTH, Bounds, Metres, Radians
from ..declare import Open, Value
from ..interfaces.channel import Signals
from ..interfaces.device import Reading
from .course import course_range, declared
from .monitor import Monitor

MOST_BEAMS = 1000
"""Maximum number of beams of one sensor; it is limited because each beam adds a value to every snapshot."""


@dataclass(frozen=True)
class BeamGroup:
    """Group of beams of a range sensor."""

    beams: tuple[int, ...]  # indices in the values of the sensor; empty for a blind group
    weights: tuple[float, ...]  # of each beam, in (0, 1]

    @cached_property
    def weighed(self) -> tuple[tuple[int, float], ...]:
        """Pairs of beam index and weight."""
        return tuple(zip(self.beams, self.weights, strict=True))


class GroupTable(Value):
    """Table `[monitor.group.NAME]` of a RangeMonitor.

    Attributes:
        beams: Indices into the sensor's values.
        weights: Weight of each beam; 1 by default.
        blind: Whether the robot has no sensor in this direction.
    """

    beams: tuple[int, ...] = ()
    weights: tuple[float, ...] = ()
    blind: bool = False


class RangeMonitor(Monitor):
    """Writes the beams of a range sensor as a signal with the sensor's name, and its groups (docs/architecture.md).

    Each beam of a group has a weight in (0, 1]. An obstacle at range r counts as one at r / weight straight ahead, so
    that a rule can compare a whole group with one threshold.

    A robot without a sensor in a direction declares that group with `blind = true` and no beams. The group is then one
    value, +inf (no echo), so that shared rules run. The declaration is required because a missing group is an error.

    If the bearings of the beams are declared, and the robot can move sideways, the monitor also writes `course_range`:
    the range in the direction of motion. It is +inf while the robot is stationary, and if no beam is within 60 deg of
    this direction.

    Attributes:
        beams: Number of beams of the sensor.
        min_vanish_range: Range below which an echo cannot vanish from all beams between two readings [m]; 0 disables
            the check. A ring without any echo after such an echo counts as broken until it has an echo again.
        bearings: Bearings of the beams, body frame, left positive [rad], one per beam; empty if unknown.
        group: Groups by name: `beams` (indices into the sensor's values) and `weights` (default 1), or `blind = true`.
        groups: Groups by name.

    Raises:
        InputError: A group is invalid.
    """

    beams: Annotated[int, Bounds(1, MOST_BEAMS)]
    group: Mapping[str, GroupTable] = Open()
    min_vanish_range: Metres = 0.0
    bearings: tuple[Radians, ...] = ()

    def __post_init__(self) -> None:
        self._nearest = math.inf
        if self.bearings and len(self.bearings) != self.beams:
            found = f"found {len(self.bearings)} for {self.beams} beams"
            raise InputError(Fault(f"bearings of monitor '{self.name}' must be one angle per beam, {found}."))
        lateral = bool(self.bearings) and "vy" in self.knowledge.robot.axes
        self._bearings = np.array(self.bearings, dtype=float) if lateral else None
        self.groups = {name: self._group(name, table) for name, table in self.group.items()}

    def signals(self) -> Sequence[Signal]:
        def declare(name: str, size: int, doc: str) -> Signal:
            return Signal(name, size, (LENGTH,) * size, (0.0, math.inf), self.max_age, doc)

        raw = declare(self.monitored[0].sensor.name, self.beams, "Range by beam; +inf without an echo.")
        groups = (
            declare(name, len(g.beams), f"Beams {list(g.beams)}, each range divided by its weight.")
            if g.beams
            else declare(name, 1, "No beam in this direction: +inf, never an echo.")
            for name, g in self.groups.items()
        )
        return [raw, *groups, *(() if self._bearings is None else declared(["course_range"], self.max_age))]

    def expects(self) -> Mapping[str, int]:
        return {self.monitored[0].sensor.name: self.beams}

    def reject(self, sensor: str, reading: Reading) -> str:
        values = reading.values
        if any(map(math.isnan, values)):
            values = [v for v in values if not math.isnan(v)]
        nearest = min(values, default=math.nan)
        if nearest == math.inf and self._nearest < self.min_vanish_range:
            return f"silent: the echo at {self._nearest:.2f} m vanished from all beams at once"
        if not math.isnan(nearest):
            self._nearest = nearest
        return ""

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        name, reading = next(iter(readings.items()))
        values = reading.values
        written: dict[str, Sequence[float]] = {name: values}
        for group, g in self.groups.items():
            written[group] = [values[b] / w for b, w in g.weighed] or [math.inf]
        if self._bearings is not None:
            twist = self.knowledge.robot.twist()
            written["course_range"] = [course_range(self._bearings, np.array(values), twist)]
        return written

    def _group(self, name: str, group: GroupTable) -> BeamGroup:
        beams, weights = tuple(group.beams), tuple(group.weights or (1.0,) * len(group.beams))
        where = f"group '{name}' of monitor '{self.name}'"
        if group.blind:
            if beams or weights:
                raise InputError(Fault(f"{where} is blind, but has beams {list(beams)} and weights {list(weights)}."))
            return BeamGroup((), ())
        if not beams or any(b < 0 or b >= self.beams for b in beams):
            hint = "" if beams else "If the robot has no sensor in this direction, write blind = true instead."
            message = f"{where} must list beams between 0 and {self.beams - 1}, found {list(beams)}."
            raise InputError(Fault(message, hint=hint))
        if len(weights) != len(beams) or any(not 0.0 < w <= 1.0 for w in weights):
            raise InputError(Fault(f"{where} must have one weight in (0, 1] for each beam, found {list(weights)}."))
        return BeamGroup(beams, weights)
