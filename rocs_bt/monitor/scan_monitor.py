"""ScanMonitor: ranges of a lidar, and the standard groups of sectors that rules use."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2
from ..base.signal import Signal
from ..base.units import LENGTH, Bounds, Radians, Seconds
from ..declare import Open, Value
from ..interfaces.channel import Signals
from ..interfaces.device import Reading
from .course import course_range, declared
from .monitor import Monitor

Array = npt.NDArray[np.float64]

SCAN = "scan"
"""Name of the signal with the ranges of the lidar."""

MOST_BEAMS = 4000
"""Maximum number of rays; it is limited because each ray adds a value to every snapshot."""


@dataclass(frozen=True)
class _Sector:
    first: int
    last: int  # one past
    weight: float


class SectorTable(Value):
    """Table `[monitor.group.NAME]` of a ScanMonitor.

    Attributes:
        sectors: Pairs of bearings from the scanner's axis, left positive [rad].
        weights: Weight of each sector; 1 by default.
        blind: Whether the scanner has no ray in this direction.
    """

    sectors: tuple[tuple[Radians, Radians], ...] = ()
    weights: tuple[float, ...] = ()
    blind: bool = False


class ScanMonitor(Monitor):
    """Writes the ranges of a lidar as the signal `scan`, and standard groups of its sectors (docs/architecture.md).

    The value of a sector is the minimum gap [m] between the robot's hull and the echoes of the sector's rays, divided
    by the sector's weight in (0, 1]: an obstacle with a gap g counts as one at g / weight straight ahead. So rules for
    a ring of sonars on the hull also work for a scanner inside the hull. The hull is the box of [body], centred on the
    base. A NaN ray makes its sectors NaN, because a robot that cannot see must not drive.

    On a robot that can move sideways, the monitor also writes `course_range`: the gap in the direction of motion. It is
    +inf while the robot is stationary, and if no ray is within 60 deg of this direction.

    The scanner's geometry is that of the sensor with this signal in robot.toml: `rays`, `span` and `mount`.

    Attributes:
        group: Groups by name: `sectors`, pairs of bearings from the scanner's axis, left positive [rad], and `weights`
            (default 1); or `blind = true` for a direction without rays.
        frozen_after: Parameter of every Monitor; ranges of a scanner have noise, so that two scans in motion differ.

    Raises:
        InputError: The number of rays or the span is out of range, a group is invalid, or the size of the hull is not
            declared.
    """

    group: Mapping[str, SectorTable] = Open()
    frozen_after: Annotated[Seconds, Bounds(infinite=True)] = 0.5

    def __post_init__(self) -> None:
        scanner = self.knowledge.robot.scanner(SCAN)
        if scanner.rays > MOST_BEAMS or not 0.0 < scanner.span <= math.tau + 1e-9:
            found = f"{scanner.rays} and {math.degrees(scanner.span):.4g} deg"
            message = f"monitor '{self.name}' takes at most {MOST_BEAMS} rays over at most 360 deg, found {found}."
            raise InputError(Fault(message))
        self._beams, self._bearings = scanner.rays, scanner.bearings
        self._lateral = "vy" in self.knowledge.robot.axes
        self._directions = self._bearings + scanner.mount.yaw
        self._hull = _to_hull(self._bearings, scanner.mount, self._half_sizes())
        self._groups = {name: self._sectors(name, table) for name, table in self.group.items()}
        sectors = [sector for group in self._groups.values() for sector in group]
        self._edges = [edge for sector in sectors for edge in (sector.first, sector.last)]
        self._weights = [sector.weight for sector in sectors]

    def signals(self) -> Sequence[Signal]:
        def declare(name: str, size: int, doc: str) -> Signal:
            return Signal(name, size, (LENGTH,) * size, (0.0, math.inf), self.max_age, doc)

        raw = declare(SCAN, self._beams, "Range by ray, from the right to the left; +inf without an echo.")
        groups = (
            declare(name, len(sectors), "Gap between hull and echo by sector, each divided by its weight.")
            if sectors
            else declare(name, 1, "No ray in this direction: +inf, never an echo.")
            for name, sectors in self._groups.items()
        )
        return [raw, *groups, *(declared(["course_range"], self.max_age) if self._lateral else ())]

    def expects(self) -> Mapping[str, int]:
        return {self.monitored[0].sensor.name: self._beams}

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        values = next(iter(readings.values())).values
        written: dict[str, Sequence[float]] = {SCAN: values}
        gaps = np.maximum(np.array(values) - self._hull, 0.0)
        least = iter(self._least(gaps))
        for name, sectors in self._groups.items():
            written[name] = [next(least) for _ in sectors] or [math.inf]
        if self._lateral:
            written["course_range"] = [course_range(self._directions, gaps, self.knowledge.robot.twist())]
        return written

    def _least(self, gaps: Array) -> list[float]:
        """Minimum gap of each sector of all groups, divided by its weight [m]."""
        if not self._edges:
            return []
        # Every other interval between edges is a sector; the appended +inf lets one end at the last ray.
        least = np.minimum.reduceat(np.append(gaps, math.inf), self._edges)[::2].tolist()
        return [gap / weight for gap, weight in zip(least, self._weights, strict=True)]

    def _half_sizes(self) -> tuple[float, float]:
        body = self.knowledge.graph.attributes(self.knowledge.agent)
        if not (body.get("length") and body.get("width")):
            raise InputError(Fault(f"monitor '{self.name}' needs the robot's length and width in its [body] table."))
        return 0.5 * body["length"], 0.5 * body["width"]

    def _sectors(self, name: str, group: SectorTable) -> tuple[_Sector, ...]:
        where = f"group '{name}' of monitor '{self.name}'"
        sectors, weights = group.sectors, group.weights or (1.0,) * len(group.sectors)
        if group.blind and not sectors:
            return ()
        if not sectors or len(weights) != len(sectors) or any(not 0.0 < w <= 1.0 for w in weights):
            hint = "" if sectors else "If no ray has this direction, write blind = true instead."
            message = f"{where} needs sectors, and one weight in (0, 1] for each, found {len(sectors)} and {weights}."
            raise InputError(Fault(message, hint=hint))
        return tuple(self._sector(where, *pair) for pair in zip(sectors, weights, strict=True))

    def _sector(self, where: str, edges: Sequence[float], weight: float) -> _Sector:
        inside = np.flatnonzero((self._bearings >= min(edges) - 1e-9) & (self._bearings <= max(edges) + 1e-9))
        if len(edges) != 2 or not len(inside):
            found = [f"{math.degrees(edge):.4g} deg" for edge in edges]
            raise InputError(Fault(f"a sector of {where} must be two bearings with rays between them, found {found}."))
        return _Sector(int(inside[0]), int(inside[-1]) + 1, float(weight))


def _to_hull(bearings: Array, mount: Pose2, half: tuple[float, float]) -> Array:
    """Length of the part of each ray inside the hull, shape (beams,) [m]; 0 if the scanner is outside the hull.

    Args:
        bearings: Bearings of the rays from the scanner's axis, left positive, shape (beams,) [rad].
        mount: Pose of the scanner, body frame.
        half: Half the length and half the width of the hull [m].
    """
    x, y, yaw = mount
    if abs(x) > half[0] or abs(y) > half[1]:
        return np.zeros_like(bearings)
    c, s = np.cos(bearings + yaw), np.sin(bearings + yaw)
    with np.errstate(divide="ignore", over="ignore"):
        along = np.where(c != 0.0, (np.copysign(half[0], c) - x) / c, math.inf)
        aside = np.where(s != 0.0, (np.copysign(half[1], s) - y) / s, math.inf)
    out: Array = np.minimum(along, aside)
    return out
