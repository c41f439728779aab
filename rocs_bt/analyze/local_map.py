"""LocalMap: the map that the robot makes for itself of what its lidar has seen."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ..channel import Signals, Stamped
from ..control.drive import Array
from ..control.footprint import Footprint
from ..errors import Fault, InputError
from ..event import Change
from ..geometry import Pose2, wrap_angle
from ..knowledge import OccupancyGrid
from ..signal import Signal
from ..units import TIME
from .analyze import Analyze

SCAN = "scan"
"""The signal that holds the ranges."""

CONTACT = "contact_time"
"""The signal that tells how soon the hull would touch something [s]."""

AHEAD: Array = np.arange(1.0, 25.0) * 0.05
"""The moments of the next future that are looked at for that [s]."""

POSES = 8
"""How many poses are kept, to find the one that a scan was taken from."""

NEAREST = 3
"""Cells nearer than so many sides of a cell are left alone: the robot is on them."""


class LocalMap(Analyze):
    """Draws each scan into `knowledge.world.occupancy`, from the pose that the robot had when it was taken.

    A cell with an echo gains evidence; one that a beam goes through loses some, as do all cells that the scan shows to
    be free within `horizon`. What was seen once stays while nothing speaks against it, also behind the robot, where
    the lidar does not look. A Change of kind `map` tells when cells became occupied, or ceased to be.

    After each scan it writes the signal `contact_time` [s]: when the hull would touch something on the map if the robot
    kept the speed and the turn rate that its wheels have; +inf where it would not within 1.2 s, and NaN while a beam is
    broken: who cannot see must not drive.

    Args:
        reach: How far an echo counts [m].
        horizon: How far free space is drawn [m].
        cell: Side of a cell [m].
        side: Side of the map, which rolls along with the robot [m].
        max_age: How long `contact_time` stays valid [s].

    Raises:
        InputError: A size is not positive, or nobody knows how long and wide the robot is.
    """

    def __init__(
        self,
        *args: Any,
        reach: float = 10.0,
        horizon: float = 4.0,
        cell: float = 0.05,
        side: float = 30.0,
        max_age: float = 0.15,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        sizes = {"reach": reach, "horizon": horizon, "cell": cell, "side": side, "max_age": max_age}
        if bad := [name for name, value in sizes.items() if not 0.0 < value < math.inf]:
            raise InputError(Fault(f"{', '.join(bad)} of '{self.name}' must be finite and above 0."))
        body = self.knowledge.graph.attributes(self.knowledge.agent)
        if not (body.get("length") and body.get("width")):
            raise InputError(Fault(f"'{self.name}' needs the robot's length and width in its [body] table."))
        self._footprint, self._max_age = Footprint(body["length"], body["width"]), max_age
        self._scanner, self._reach = self.knowledge.robot.scanner(SCAN), reach
        self._grid = self.knowledge.world.occupancy = OccupancyGrid(cell, side)
        self._poses: deque[tuple[float, Pose2]] = deque(maxlen=POSES)
        around = math.ceil(horizon / cell)
        rows, columns = np.mgrid[-around : around + 1, -around : around + 1]
        away = np.hypot(rows, columns)
        inside = (away <= around) & (away >= NEAREST)
        self._disc = rows[inside], columns[inside]
        self._away, bearing = away[inside] * cell, np.arctan2(rows, columns)[inside]
        self._unit = np.cos(bearing), np.sin(bearing)
        self._circle = (
            bearing / math.tau,
            self._unit[0] / (math.tau * self._away),
            self._unit[1] / (math.tau * self._away),
        )

    def expects(self) -> Sequence[str]:
        return (SCAN, "pose")

    def signals(self) -> Sequence[Signal]:
        doc = "Until the hull would touch something; +inf if not soon."
        return [Signal(CONTACT, 1, (TIME,), (0.0, math.inf), self._max_age, doc)]

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        for sample in samples:
            if "pose" in sample.value:
                self._poses.append((sample.t, Pose2(*sample.value["pose"])))
        changed = 0
        for sample in samples:
            pose = self._pose_at(sample.t) if SCAN in sample.value else None
            if pose is not None and all(map(math.isfinite, pose)):
                ranges = np.array(sample.value[SCAN])
                changed += self._draw(pose, ranges)
                seeing = not np.isnan(ranges).any()
                self.write(sample.t, {CONTACT: [self._contact(pose, sample.t) if seeing else math.nan]})
        if changed:
            yield self.change(samples[-1].t, "map", cells=changed)

    def _contact(self, pose: Pose2, t: float) -> float:
        """When the hull would touch something [s]; NaN while nobody knows how the robot moves."""
        twist = self.knowledge.robot.twist(t)
        if math.isnan(twist.forward + twist.turn):
            return math.nan
        until, c, s = float(AHEAD[-1]), math.cos(pose.yaw), math.sin(pose.yaw)
        ahead = twist.forward * until
        # An arc leaves the straight line by no more than half its length for each radian that it turns.
        aside = 0.5 * abs(ahead * twist.turn) * until + abs(twist.left) * until
        reach = self._footprint.outer + aside + self._grid.cell
        x, y = sorted((pose.x, pose.x + ahead * c)), sorted((pose.y, pose.y + ahead * s))
        points = self._grid.points((x[0] - reach, y[0] - reach), (x[1] + reach, y[1] + reach))
        dx, dy = points[:, 0] - pose.x, points[:, 1] - pose.y
        around = np.column_stack([c * dx + s * dy, c * dy - s * dx])
        return self._footprint.contact_time(around, twist, AHEAD)

    def _pose_at(self, t: float) -> Pose2 | None:
        """The robot's pose at a time [s], between the two poses around it; the last one where none is newer."""
        after: Pose2 | None = None
        for stamp, pose in reversed(self._poses):
            if stamp <= t or after is None:
                before, since = pose, stamp
            if stamp <= t:
                break
            after, until = pose, stamp
        else:
            return after
        if after is None or since == t:
            return before
        part = (t - since) / (until - since)
        turn = wrap_angle(after.yaw - before.yaw)
        x, y = before.x + part * (after.x - before.x), before.y + part * (after.y - before.y)
        return Pose2(x, y, wrap_angle(before.yaw + part * turn))

    def _draw(self, pose: Pose2, ranges: Array) -> int:
        """Draw one scan; tells how many cells changed."""
        grid, eye = self._grid, pose.compose(self._scanner.mount)
        grid.centre_on(eye.x, eye.y)
        heard = np.flatnonzero(ranges <= self._reach)  # none for NaN
        angles, distances = self._scanner.bearings[heard] + eye.yaw, ranges[heard]
        hits = np.column_stack([eye.x + distances * np.cos(angles), eye.y + distances * np.sin(angles)])
        reach = np.where(np.isnan(ranges), 0.0, np.minimum(ranges, self._reach))
        row, column = math.floor(eye.y / grid.cell), math.floor(eye.x / grid.cell)
        dx, dy = eye.x - (column + 0.5) * grid.cell, eye.y - (row + 0.5) * grid.cell
        passed, (rows, columns) = self._seen_through(dx, dy, eye.yaw, reach), self._disc
        return grid.add_scan(hits, np.stack([rows[passed] + row, columns[passed] + column]).T)

    def _seen_through(self, dx: float, dy: float, yaw: float, reach: Array) -> Any:
        """Which cells of the disc the beams go beyond, from an eye beside the centre of its middle cell [m]."""
        (c, s), (share, c_by_away, s_by_away) = self._unit, self._circle
        # To first order in the small dx and dy, in place of a root and an arctangent for each cell.
        away = self._away - dx * c
        away -= dy * s
        span, step = self._scanner.span, self._scanner.span / (len(reach) - 1)
        share = share + dx * s_by_away  # of a circle, on from the right edge of the first beam
        share -= dy * c_by_away
        share += (0.5 * (span + step) - yaw) / math.tau
        share -= np.floor(share)
        share *= math.tau / step
        limit = np.append(reach - 0.5 * self._grid.cell, [-math.inf])
        return np.flatnonzero(away < limit.take(share.astype(np.intp), mode="clip"))
