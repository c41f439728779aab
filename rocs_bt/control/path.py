"""Planar paths, sampled by arc length."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ..base.errors import InputError
from .locomotion import Array

SPACING = 0.01  # [m] cuts a right-angled corner by less than 4 mm
MAX_SAMPLES = 1_000_000  # 10 km at that spacing: about 100 MB of arrays
REACH = 0.05  # [m] half the chord that defines the heading; smooths the kinks of a polyline


class Grid:
    """Linear interpolation of a function sampled at even steps from 0 on, constant beyond both ends.

    Args:
        rows: Values at 0, spacing, 2 spacing and so on, shape (n, c).
        spacing: Step; 0 for a constant function.
    """

    def __init__(self, rows: Array, spacing: float) -> None:
        self._rows = np.ascontiguousarray(rows, dtype=float)
        # A final row of zero slope, so that the last sample needs no special case.
        self._slopes = np.vstack([np.diff(rows, axis=0), np.zeros((1, rows.shape[1]))])
        self._last = len(rows) - 1
        self._per_unit = 1.0 / spacing if spacing > 0.0 else 0.0

    def at(self, arguments: Array) -> Array:
        """Interpolated rows at arguments (k,), shape (k, c)."""
        steps = np.minimum(np.maximum(arguments * self._per_unit, 0.0), self._last)
        cell = steps.astype(np.intp)
        rows: Array = self._rows.take(cell, axis=0) + (steps - cell)[:, None] * self._slopes.take(cell, axis=0)
        return rows

    def row(self, argument: float) -> list[float]:
        """Interpolated row at one argument, as c plain numbers."""
        step = min(max(argument * self._per_unit, 0.0), self._last)
        cell = int(step)
        part = step - cell
        slopes = self._slopes[cell].tolist()
        return [low + part * slope for low, slope in zip(self._rows[cell].tolist(), slopes, strict=True)]


class Path:
    """Polyline resampled at equal arc length, with heading and curvature.

    Heading and curvature are computed from chords that reach `REACH` in both directions, so a corner becomes a short,
    sharp bend, and the small kinks of a sampled curve are smoothed. Repeated points are dropped. A path of one position
    (one point, or all points equal) is allowed: its length, heading and curvature are 0.

    Args:
        points: Positions along the path, world frame, shape (m, 2) [m].
        spacing: Maximum arc length between samples [m]; it is reduced so that the samples divide the path evenly.

    Attributes:
        length: Arc length [m].
        spacing: Arc length between samples [m].
        samples: x [m], y [m], continuous heading [rad], curvature, left positive [1/m]; read-only, shape (n, 4).

    Raises:
        InputError: There are no points, they have another shape, they are not finite, or the path is longer than
            `MAX_SAMPLES` times the spacing.
    """

    def __init__(self, points: npt.ArrayLike, spacing: float = SPACING) -> None:
        corners = _distinct(_checked(points))
        if not spacing > 0.0:
            raise InputError(f"the spacing of a path must be positive, found {spacing} m.")
        stations = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
        self.length = float(stations[-1])
        if not self.length <= MAX_SAMPLES * spacing:
            raise InputError(f"a path may be {MAX_SAMPLES * spacing:g} m long, found {self.length:g} m.")
        cells = max(4, math.ceil(self.length / spacing))
        self.spacing = self.length / cells
        at = np.linspace(0.0, self.length, cells + 1)
        xy = np.column_stack([np.interp(at, stations, corners[:, i]) for i in (0, 1)])
        heading, curvature = _bend(xy, self.spacing) if self.length > 0.0 else (0.0 * at, 0.0 * at)
        self.samples: Array = np.column_stack([xy, heading, curvature])
        self.samples.flags.writeable = False
        self._xs, self._ys = xy[:, 0].copy(), xy[:, 1].copy()
        self._per_metre = 1.0 / self.spacing if self.length > 0.0 else 0.0
        self._grid = Grid(self.samples, self.spacing)
        self._cells = cells

    @classmethod
    def line(cls, a: Sequence[float], b: Sequence[float]) -> Path:
        """Straight path from a to b; their first two numbers are x and y, world frame [m]."""
        return cls([list(a[:2]), list(b[:2])])

    @classmethod
    def through(cls, points: npt.ArrayLike, corner_radius: float = 0.0) -> Path:
        """Polyline with corners rounded by arcs.

        Args:
            points: Corners, shape (m, 2) [m].
            corner_radius: Radius of the arcs, reduced if a leg is too short; 0 keeps sharp corners [m].

        Raises:
            InputError: As for the class, or the radius is negative.
        """
        if not corner_radius >= 0.0:
            raise InputError(f"a corner radius must be 0 or more, found {corner_radius} m.")
        corners = _distinct(_checked(points))
        if corner_radius == 0.0 or len(corners) < 3:
            return cls(corners)
        arcs = [_arc(*corner, corner_radius) for corner in zip(corners, corners[1:], corners[2:], strict=False)]
        return cls(np.vstack([corners[:1], *arcs, corners[-1:]]))

    def at(self, s: npt.ArrayLike) -> Array:
        """Interpolated samples at one or k arc lengths [m], shape (4,) or (k, 4); constant beyond both ends.

        Columns: x [m], y [m], continuous heading [rad], curvature [1/m].
        """
        rows = self._grid.at(np.atleast_1d(np.asarray(s, dtype=float)))
        return rows if np.ndim(s) else rows[0]

    def sample(self, s: float) -> tuple[float, float, float, float]:
        """Interpolated x [m], y [m], heading [rad] and curvature [1/m] at one arc length [m]; faster than `at`."""
        x, y, heading, curvature = self._grid.row(s)
        return x, y, heading, curvature

    def outline(self, tolerance: float = 0.01) -> list[tuple[float, float]]:
        """Corners of a polyline from which the path differs by at most a tolerance [m], rounded to 1 mm."""
        points, kept, todo = self.samples[:, :2], [0], [(0, len(self.samples) - 1)]
        while todo:
            first, last = todo.pop()
            off = points[first + 1 : last] - points[first]
            x, y = points[last] - points[first]
            chord = math.hypot(x, y)
            far = np.hypot(*off.T) if chord < tolerance else np.abs(off[:, 0] * y - off[:, 1] * x) / chord
            if len(far) and far.max() > tolerance:
                middle = first + 1 + int(far.argmax())
                todo += [(middle, last), (first, middle)]
            else:
                kept.append(last)
        return [(round(x, 3), round(y, 3)) for x, y in points[kept].tolist()]

    def position(self, s: npt.ArrayLike) -> Array:
        """Positions at arc lengths s [m], world frame, shape (2,) or (k, 2) [m]."""
        return self.at(s)[..., :2]

    def heading(self, s: npt.ArrayLike) -> Array:
        """Tangent directions at arc lengths s [m], without jumps of 2 pi, shape () or (k,) [rad]."""
        return self.at(s)[..., 2]

    def curvature(self, s: npt.ArrayLike) -> Array:
        """Curvatures at arc lengths s [m], left positive, shape () or (k,) [1/m]."""
        return self.at(s)[..., 3]

    def project(self, x: float, y: float, hint: float | None = None, window: float = 0.5, least: float = 0.0) -> float:
        """Arc length of the nearest point on the path [m].

        With a hint, only a window of the path around the hint is searched, so that a path that crosses itself is
        followed in order. The window doubles while the nearest point is at its edge or farther away than half its
        width, so that a robot that was carried away is found, too.

        Args:
            x: Position, world frame [m].
            y: Position, world frame [m].
            hint: Arc length at which the search begins; None searches the whole path [m].
            window: Initial search distance from the hint, each way [m].
            least: Minimum arc length of the result [m].
        """
        if self.length == 0.0:
            return 0.0
        last = self._cells
        first = min(max(math.ceil(least * self._per_metre), 0), last)
        low, high, middle = first, last, first
        if hint is not None:
            middle = min(max(round(hint * self._per_metre), first), last)
        half = last if hint is None else max(2, math.ceil(window * self._per_metre))
        while True:
            low, high = max(first, middle - half), min(last, middle + half)
            dx, dy = self._xs[low : high + 1] - x, self._ys[low : high + 1] - y
            squares = dx * dx + dy * dy
            nearest = int(squares.argmin())
            best, squared = low + nearest, float(squares[nearest])
            inside = (low < best or low == first) and (best < high or high == last)
            whole = low == first and high == last
            if whole or (inside and squared <= (half * self.spacing) ** 2):
                return max(min(least, self.length), self._refine(x, y, best))
            half *= 2

    def _refine(self, x: float, y: float, best: int) -> float:
        """Arc length of the point nearest to (x, y) on the two segments that meet at sample number `best` [m]."""
        nearest, found = math.inf, best * self.spacing
        for cell in (best - 1, best):
            if not 0 <= cell < self._cells:
                continue
            (ax, bx), (ay, by) = self._xs[cell : cell + 2].tolist(), self._ys[cell : cell + 2].tolist()
            dx, dy = bx - ax, by - ay
            length2 = dx * dx + dy * dy
            t = min(max(((x - ax) * dx + (y - ay) * dy) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
            distance = math.hypot(ax + t * dx - x, ay + t * dy - y)
            if distance < nearest:
                nearest, found = distance, (cell + t) * self.spacing
        return found


def _checked(points: npt.ArrayLike) -> Array:
    array = np.array(points, dtype=float)
    if array.ndim != 2 or array.shape[1] != 2 or len(array) == 0:
        raise InputError(f"a path needs one or more points as rows of x, y; found an array of shape {array.shape}.")
    if not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise InputError(f"point {row} of a path must be finite, found {array[row].tolist()}.")
    return array


def _distinct(points: Array) -> Array:
    kept = np.concatenate([[True], np.hypot(*np.diff(points, axis=0).T) > 1e-9])
    distinct: Array = points[kept]
    return distinct


def _bend(xy: Array, spacing: float) -> tuple[Array, Array]:
    """Continuous heading [rad] and curvature [1/m] of evenly spaced points, from chords of `REACH` each way."""
    last = len(xy) - 1
    index = np.arange(last + 1)
    reach = max(1, round(REACH / spacing))
    # Near the ends the chord is shortened on both sides, so that it remains the tangent of an arc.
    side = np.maximum(np.minimum(np.minimum(index, last - index), reach), 1)
    fore, aft = np.minimum(index + side, last), np.maximum(index - side, 0)
    chord = xy[fore] - xy[aft]
    # Where a path doubles back, the chord vanishes; the next segment then gives the heading.
    onward = np.minimum(index, last - 1)
    lost = np.hypot(*chord.T) < 0.1 * spacing * (fore - aft)
    chord[lost] = (xy[onward + 1] - xy[onward])[lost]
    heading = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    return heading, (heading[fore] - heading[aft]) / ((fore - aft) * spacing)


def _arc(before: Array, corner: Array, after: Array, radius: float) -> Array:
    """Points on the arc that rounds a corner, shape (k, 2) [m]; only the corner if the path is straight there."""
    to, away = corner - before, after - corner
    length_to, length_away = float(np.hypot(*to)), float(np.hypot(*away))
    to, away = to / length_to, away / length_away
    turn = math.atan2(to[0] * away[1] - to[1] * away[0], float(to @ away))
    half_tangent = math.tan(abs(turn) / 2.0)
    if not 1e-6 < half_tangent < 1e3:  # straight on, or straight back
        return corner[None]
    cut = min(radius * half_tangent, 0.5 * length_to, 0.5 * length_away)
    radius = cut / half_tangent
    start, sign = corner - cut * to, math.copysign(1.0, turn)
    angles = np.linspace(0.0, abs(turn), max(3, math.ceil(abs(turn) * radius / SPACING) + 1))
    normal = sign * np.array([-to[1], to[0]])
    points: Array = start + radius * (np.sin(angles)[:, None] * to + (1.0 - np.cos(angles))[:, None] * normal)
    return points
