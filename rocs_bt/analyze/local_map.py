"""LocalMap: occupancy grid from a lidar, and time to contact with an obstacle."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2
from ..base.signal import Signal
from ..base.units import TIME, PositiveMetres, PositiveSeconds
from ..control.locomotion import Array
from ..event import Change, MapChanged
from ..interfaces.channel import Signals, Stamped
from ..knowledge import OccupancyGrid, View
from .analyze import Analyze
from .pose_history import PoseHistory

SCAN = "scan"
"""Name of the signal with the ranges of the lidar."""

CONTACT = "contact_time"
"""Name of the signal with the time until the hull touches an obstacle [s]."""

AHEAD: Array = np.arange(1.0, 25.0) * 0.05
"""Times at which contact is checked, from now on [s]."""

RECORD_EVERY = 1.0
"""Minimum time between two recorded changes of the map [s]."""

RECENT = 0.1
"""Time since the last detection of a mover within which its place is certain enough to change the map [s]."""

ROOM = 0.1
"""Distance from the outline of a mover within which echoes count as the mover's [m]."""

NEAREST = 3
"""Distance from the scanner below which cells are not marked free, because the robot covers them [cells]."""


class LocalMap(Analyze):
    """Enters each scan into `knowledge.world.occupancy`, at the pose of the robot when the scan was taken.

    A cell with an echo gains evidence. Cells that a beam crosses within `max_raytrace_range` lose evidence. Occupied
    cells remain until a beam contradicts them, also behind the robot, outside the lidar's view. A Change of kind `map`
    reports that cells became occupied or free.

    The map keeps what does not move. If the robot also has a `TrackObjects`, the echoes of movers are obstacles only
    until the next scan, and the cells that a mover crosses are cleared.

    After each scan it writes the signal `contact_time` [s]: the time until the hull would touch an obstacle of the map
    at the present speed and turn rate of the wheels. It is +inf without contact within 1.2 s, and NaN while a beam is
    NaN, because a robot that cannot see must not drive.

    Attributes:
        max_range: Maximum range of an echo [m].
        max_raytrace_range: Maximum range of free space [m].
        cell_size: Side of a cell [m].
        map_size: Side of the map, which moves with the robot [m].
        max_age: Validity of `contact_time` [s]; None for that of a scan.

    Raises:
        InputError: The robot's length and width are not declared.
    """

    max_range: PositiveMetres = 10.0
    max_raytrace_range: PositiveMetres = 4.0
    cell_size: PositiveMetres = 0.05
    map_size: PositiveMetres = 30.0
    max_age: PositiveSeconds | None = None

    def __post_init__(self) -> None:
        if (hull := self.knowledge.robot.hull) is None:
            raise InputError(Fault(f"'{self.name}' needs the robot's length and width in its [body] table."))
        self._footprint, self._scanner = hull, self.knowledge.robot.scanner(SCAN)
        self._grid = self.knowledge.world.occupancy = OccupancyGrid(self.cell_size, self.map_size)
        self._recorded, self._record_at, self._occupied = 0, -math.inf, set[tuple[int, int]]()
        self._poses = PoseHistory()
        around = math.ceil(self.max_raytrace_range / self.cell_size)
        rows, columns = np.mgrid[-around : around + 1, -around : around + 1]
        away = np.hypot(rows, columns)
        inside = (away <= around) & (away >= NEAREST)
        self._disc = rows[inside], columns[inside]
        self._away, bearing = away[inside] * self.cell_size, np.arctan2(rows, columns)[inside]
        self._unit = np.cos(bearing), np.sin(bearing)
        self._circle = (
            bearing / math.tau,
            self._unit[0] / (math.tau * self._away),
            self._unit[1] / (math.tau * self._away),
        )

    def expects(self) -> Sequence[str]:
        return (SCAN, "pose")

    def signals(self) -> Sequence[Signal]:
        doc = "Time until the hull touches an obstacle; +inf if not soon."
        signals = self.knowledge.signals  # the scan is declared before the analysers' signals
        age = self.max_age or (signals.spec(SCAN).max_age if SCAN in signals else math.inf)
        return [Signal(CONTACT, 1, (TIME,), (0.0, math.inf), age, doc)]

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        self._poses.take(samples)
        changed = 0
        for sample in samples:
            pose = self._poses.at(sample.t) if SCAN in sample.value else None
            if pose is not None:
                ranges = np.array(sample.value[SCAN])
                changed += self._enter(sample.t, pose, ranges)
                seeing = not np.isnan(ranges).any()
                contact = self._contact(self.now(sample.t), pose) if seeing else math.nan
                self.write(sample.t, {CONTACT: [contact]})
        if samples and self._grid.revision != self._recorded and (now := self.now(samples[-1].t)) >= self._record_at:
            self._record(now)
        if changed:
            yield self.change(samples[-1].t, "map", cells=changed)

    def _record(self, t: float) -> None:
        """Emit the cells of the map that have changed since the last time."""
        self._recorded, self._record_at = self._grid.revision, t + RECORD_EVERY
        before, now = self._occupied, {(x, y) for y, x in self._grid.occupied().tolist()}
        self._occupied = now
        new, gone = tuple(sorted(now - before)), tuple(sorted(before - now))
        if new or gone:
            event = MapChanged(t=t, agent=self.knowledge.agent, cell=self._grid.cell, occupied=new, cleared=gone)
            self._sink.emit(event)

    def _contact(self, now: float, seen_from: Pose2) -> float:
        """Time until the hull touches an obstacle [s]; NaN while the robot's twist is unknown."""
        twist = self.knowledge.robot.twist(now)
        if math.isnan(twist.forward + twist.left + twist.turn):
            return math.nan
        pose = self._poses.present(now, twist) or seen_from
        until, c, s = float(AHEAD[-1]), math.cos(pose.yaw), math.sin(pose.yaw)
        ahead = twist.forward * until
        # An arc deviates from the straight line by at most half its length per radian of turn.
        aside = 0.5 * abs(ahead * twist.turn) * until + abs(twist.left) * until
        reach = self._footprint.outer + aside + self._grid.cell
        x, y = sorted((pose.x, pose.x + ahead * c)), sorted((pose.y, pose.y + ahead * s))
        points = self._grid.points((x[0] - reach, y[0] - reach), (x[1] + reach, y[1] + reach))
        dx, dy = points[:, 0] - pose.x, points[:, 1] - pose.y
        around = np.column_stack([c * dx + s * dy, c * dy - s * dx])
        return self._footprint.contact_time(around, twist, AHEAD)

    def _enter(self, t: float, pose: Pose2, ranges: Array) -> int:
        """Enter one scan into the grid; return the number of changed cells."""
        grid, eye = self._grid, pose.compose(self._scanner.mount)
        grid.centre_on(eye.x, eye.y)
        echoes = np.flatnonzero(ranges <= self.max_range)  # without NaN
        angles, distances = self._scanner.bearings[echoes] + eye.yaw, ranges[echoes]
        hits = np.column_stack([eye.x + distances * np.cos(angles), eye.y + distances * np.sin(angles)])
        moving, cleared = self._movers_among(t, hits)
        reach = np.where(np.isnan(ranges), 0.0, np.minimum(ranges, self.max_range))
        row, column = math.floor(eye.y / grid.cell), math.floor(eye.x / grid.cell)
        dx, dy = eye.x - (column + 0.5) * grid.cell, eye.y - (row + 0.5) * grid.cell
        passed, (rows, columns) = self._seen_through(dx, dy, eye.yaw, reach), self._disc
        step = self._scanner.span / (len(ranges) - 1)
        cells = np.stack([rows[passed] + row, columns[passed] + column]).T
        view = View(eye, self._scanner.span + step)
        return cleared + grid.add_scan(hits[~moving], cells, view, hits[moving])

    def _movers_among(self, t: float, hits: Array) -> tuple[npt.NDArray[np.bool_], int]:
        """Clear the cells of movers in view; return which echoes are theirs, and the number of changed cells."""
        movers = self.knowledge.world.movers
        if movers is None or not (seen := movers.seen >= movers.t - RECENT).any():
            return np.zeros(len(hits), np.bool_), 0
        at = movers.mean[seen, :2] + (t - movers.t) * movers.mean[seen, 2:]
        dx, dy = (hits[:, None] - at).transpose(2, 0, 1)
        moving: npt.NDArray[np.bool_] = (np.hypot(dx, dy) < movers.radius[seen] + ROOM).any(axis=1)
        return moving, self._grid.forget(at, movers.radius[seen])

    def _seen_through(self, dx: float, dy: float, yaw: float, reach: Array) -> Any:
        """Indices of those cells around the scanner (`self._disc`) that the beams cross.

        Args:
            dx: Offset of the scanner from the centre of the disc's middle cell, east [m].
            dy: Offset of the scanner from the centre of the disc's middle cell, north [m].
            yaw: Yaw of the scanner, world frame [rad].
            reach: Free range of each beam, shape (beams,) [m].
        """
        (c, s), (share, c_by_away, s_by_away) = self._unit, self._circle
        # First order in the small dx and dy, which saves a root and an arctangent per cell.
        away = self._away - dx * c
        away -= dy * s
        span, step = self._scanner.span, self._scanner.span / (len(reach) - 1)
        share = share + dx * s_by_away  # share of a full circle, from the right edge of the first beam
        share -= dy * c_by_away
        share += (0.5 * (span + step) - yaw) / math.tau
        share -= np.floor(share)
        share *= math.tau / step
        limit = np.append(reach - 0.5 * self._grid.cell, [-math.inf])
        return np.flatnonzero(away < limit.take(share.astype(np.intp), mode="clip"))
