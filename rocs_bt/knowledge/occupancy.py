"""OccupancyGrid: occupancy evidence by cell, and the mean position of the echoes in each cell.

Source: Moravec and Elfes, High resolution maps from wide angle sonar, ICRA 1985; Thrun, Burgard and Fox, Probabilistic
Robotics (2005), 9.2 (log odds, added up and bounded).
"""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.errors import KnowledgeError
from ..base.geometry import Pose2
from .signals import Array

MAX_ECHOES = 20
"""Maximum weight of past echoes in a cell's mean position, in echoes; bounded to follow a moving obstacle."""

UNKNOWN, FREE, OCCUPIED = -1, 0, 1
"""States of a cell."""

HIT, MISS = 0.9, -0.4
"""Change of a cell's log odds by one scan: for an echo in it, and for a beam through it."""

EVIDENCE_LIMIT = 3.6
"""Maximum absolute log odds of a cell; bounded so that new observations can still change its state."""

FREE_BELOW, OCCUPIED_ABOVE = -0.2, 0.5
"""Log odds below which a cell is free, and above which it is occupied; in between it is unknown."""

MAX_CELLS = 4_000_000
"""Maximum number of cells of a grid."""

Cells = npt.NDArray[np.intp]
"""Rows and columns of cells, shape (k, 2)."""

Indices = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Window:
    """Copy of a rectangle of a grid.

    Attributes:
        states: UNKNOWN, FREE or OCCUPIED, shape (rows, columns); row 0 is the southernmost, column 0 the westernmost.
        echoes: Mean position of the echoes in each cell, world frame [m], shape (rows, columns, 2); meaningless in
            cells without echoes.
        x: Western edge, world frame [m].
        y: Southern edge, world frame [m].
        cell: Side of a cell [m].
        revision: `revision` of the grid at the time of the copy, or `still_revision` if it is without what moves.
    """

    states: npt.NDArray[np.int8]
    echoes: Array
    x: float
    y: float
    cell: float
    revision: int

    def points(self) -> Array:
        """Obstacle points: the mean echo of each occupied cell, world frame [m], shape (k, 2)."""
        points: Array = self.echoes.reshape(-1, 2)[np.flatnonzero(self.states == OCCUPIED)]
        return points


@dataclass(frozen=True)
class View:
    """Field of view of a scanner.

    Attributes:
        eye: Pose of the scanner, world frame.
        span: Angle of the field of view, half of it to each side [rad].
    """

    eye: Pose2
    span: float

    def contains(self, x: Array, y: Array) -> npt.NDArray[np.bool_]:
        """Whether points [m] are in directions in which the scanner looks."""
        turn = np.arctan2(y - self.eye.y, x - self.eye.x) - self.eye.yaw
        inside: npt.NDArray[np.bool_] = np.abs(np.mod(turn + math.pi, math.tau) - math.pi) <= 0.5 * self.span
        return inside


class OccupancyGrid:
    """Square grid of cells that moves with the robot; cells that leave the square are forgotten.

    Safe with one writer and many readers on other threads.

    Args:
        cell: Side of a cell [m].
        side: Side of the square [m].

    Attributes:
        revision: Number of changes of the set of occupied cells, including every move and every `clear`.
        still_revision: The same without the echoes of what moves.

    Raises:
        KnowledgeError: A size is not positive, or there would be more than `MAX_CELLS`.
    """

    def __init__(self, cell: float = 0.05, side: float = 40.0) -> None:
        if not (0.0 < cell < math.inf and cell <= side < math.inf):
            raise KnowledgeError(f"a grid needs a cell of positive size and a side no less, found {cell} m, {side} m.")
        self.cell = cell
        self._count = math.ceil(side / cell)
        if self._count**2 > MAX_CELLS:
            raise KnowledgeError(
                f"a grid of {side} m with cells of {cell} m has {self._count**2} cells; the most are {MAX_CELLS}. "
                "Take a greater cell or a smaller side."
            )
        self.revision = self.still_revision = 0
        self._lock = threading.Lock()
        self._evidence = np.zeros((self._count, self._count), np.float32)
        self._echoes = np.zeros((self._count, self._count, 2), np.float32)  # from the cell's centre [m]
        self._echo_counts = np.zeros((self._count, self._count), np.float32)  # at most MAX_ECHOES
        self._corner = np.array([-(self._count // 2), -(self._count // 2)])  # row and column of its first cell
        self._latest: tuple[Array, Cells] = np.zeros((0, 2)), np.zeros((0, 2), np.intp)  # scan that was added last
        self._moving: Array = np.zeros((0, 2))
        self._view: View | None = None

    def cells(self, points: Array) -> Cells:
        """Rows and columns of the cells at points [m], both of shape (k, 2), counted from the world origin."""
        cells: Cells = np.floor(points[:, ::-1] / self.cell).astype(np.intp)
        return cells

    def centres(self, cells: Cells) -> Array:
        """Centres of cells, world frame [m], shape (k, 2)."""
        return np.asarray((cells[:, ::-1] + 0.5) * self.cell, dtype=float)

    def centre_on(self, x: float, y: float) -> None:
        """Centre the grid on a point [m], unless it is less than an eighth of the side from the present centre."""
        wanted = [math.floor(v / self.cell) - self._count // 2 for v in (y, x)]
        shift = [new - old for new, old in zip(wanted, self._corner.tolist(), strict=True)]
        if max(map(abs, shift)) <= self._count // 8:
            return
        with self._lock:
            here, there = zip(*(_overlap(s, self._count) for s in shift), strict=True)
            for name in ("_evidence", "_echoes", "_echo_counts"):
                old = getattr(self, name)
                rolled = np.zeros_like(old)
                rolled[there] = old[here]
                setattr(self, name, rolled)
            self._corner = np.array(wanted)
            self._count_change()

    def add_scan(self, hits: Array, passed: Cells, view: View | None = None, moving: Array | None = None) -> int:
        """Add one scan: positions of echoes, and cells that a beam passed through.

        A cell that is in both counts as an echo. Points outside the grid are ignored.

        Args:
            hits: Positions of the echoes, world frame [m], shape (k, 2).
            passed: Cells that a beam passed through, shape (m, 2).
            view: Field of view of the scanner; None if it looks in all directions.
            moving: Positions of the echoes of what moves, shape (k, 2) [m]. They are obstacles until the next scan.

        Returns:
            Number of cells that became occupied or ceased to be.
        """
        with self._lock:
            changed = self._add(hits, passed)
            self._latest, self._view = (hits, passed), view
            before, self._moving = self._moving, np.zeros((0, 2)) if moving is None else moving
            if changed > 0:
                self._count_change()
            elif len(before) + len(self._moving) > 0:
                self.revision += 1
        return changed

    def _add(self, hits: Array, passed: Cells) -> int:
        cells = self.cells(hits)
        offsets = (hits - self.centres(cells)).astype(np.float32)
        (at, inside), (through, _) = self._flat(cells), self._flat(passed)
        hit, which, count = np.unique(at, return_inverse=True, return_counts=True)
        evidence = self._evidence.reshape(-1)
        old, sure = evidence[hit], evidence[through]
        less = np.maximum(sure + MISS, -EVIDENCE_LIMIT)
        evidence[through] = less
        # Once per cell and scan, so that a near obstacle with many echoes gains no more evidence than a far one.
        new = np.minimum(old + HIT, EVIDENCE_LIMIT)
        evidence[hit] = new
        self._locate(hit, which, count, offsets[inside])
        gone = through[(sure > OCCUPIED_ABOVE) & (less <= OCCUPIED_ABOVE)]
        gone = np.unique(gone[evidence[gone] <= OCCUPIED_ABOVE])
        return len(gone) + int(np.count_nonzero((old > OCCUPIED_ABOVE) != (new > OCCUPIED_ABOVE)))

    def _locate(self, hit: Indices, which: Indices, count: Indices, offsets: npt.NDArray[np.float32]) -> None:
        """Update the mean echo positions of the cells with new echoes."""
        echoes, counts = self._echoes.reshape(-1, 2), self._echo_counts.reshape(-1)
        known = np.minimum(counts[hit], MAX_ECHOES)
        total = known + count
        fresh = np.column_stack([np.bincount(which, offsets[:, axis], len(hit)) for axis in (0, 1)])
        echoes[hit] = (echoes[hit] * known[:, None] + fresh) / total[:, None]
        counts[hit] = np.minimum(total, MAX_ECHOES)

    def clear(self, x: float, y: float, radius: float, *, outside: bool = False) -> None:
        """Reset all cells around a point [m] to unknown, and enter what the latest scan saw in them.

        The reflexes read this grid, so the robot keeps what it sees, and all cells at which it cannot look at present,
        such as those behind it.

        Args:
            x: Point, world frame [m].
            y: Point, world frame [m].
            radius: Radius around the point [m]; infinite for all cells.
            outside: Whether the cells outside of the radius are reset instead.
        """
        with self._lock:
            rows, columns = np.indices(self._evidence.shape) + self._corner[:, None, None]
            away = np.hypot((columns + 0.5) * self.cell - x, (rows + 0.5) * self.cell - y)
            chosen = (away <= radius) != outside
            if self._view is not None:
                chosen &= self._view.contains((columns + 0.5) * self.cell, (rows + 0.5) * self.cell)
            self._evidence[chosen] = self._echo_counts[chosen] = 0.0
            hits, passed = self._latest
            self._add(hits[self._among(chosen, self.cells(hits))], passed[self._among(chosen, passed)])
            self._count_change()

    def forget(self, centres: Array, radii: Array) -> int:
        """Reset the cells in some discs to unknown, such as those that something moving crosses.

        Args:
            centres: Centres of the discs, world frame, shape (k, 2) [m].
            radii: Their radii, shape (k,) [m].

        Returns:
            Number of cells that were occupied.
        """
        around = math.ceil(float(radii.max(initial=0.0)) / self.cell)
        beside = self.cells(centres)[..., None] + np.arange(-around, around + 1)  # rows and columns, (k, 2, n)
        apart = (beside + 0.5) * self.cell - centres[:, ::-1, None]
        apart *= apart
        disc, i, j = np.nonzero(apart[:, 1, None, :] + apart[:, 0, :, None] <= (radii * radii)[:, None, None])
        cells = np.column_stack([beside[disc, 0, i], beside[disc, 1, j]])
        with self._lock:
            flat, _ = self._flat(cells)
            evidence = self._evidence.reshape(-1)
            gone = len(np.unique(flat[evidence[flat] > OCCUPIED_ABOVE]))
            evidence[flat] = self._echo_counts.reshape(-1)[flat] = 0.0
            if gone:
                self._count_change()
        return gone

    def occupied(self) -> Cells:
        """All occupied cells, shape (k, 2)."""
        with self._lock:
            cells: Cells = np.argwhere(self._evidence > OCCUPIED_ABOVE) + self._corner
        return cells

    def state(self, x: float, y: float) -> int:
        """State of the cell at a point [m]: UNKNOWN, FREE or OCCUPIED; UNKNOWN outside the grid."""
        with self._lock:
            at, _ = self._flat(self.cells(np.array([[x, y]])))
            return int(_states(self._evidence.reshape(-1)[at])[0]) if len(at) else UNKNOWN

    def window(self, low: tuple[float, float], high: tuple[float, float], *, moving: bool = True) -> Window:
        """A copy of a rectangle of cells; cells outside the grid are UNKNOWN.

        Args:
            low: Point in its south-western cell, world frame [m].
            high: Point in its north-eastern cell, world frame [m].
            moving: Whether the cells with echoes of what moves are occupied, too.
        """
        (row, column), (top, right) = self.cells(np.array([low, high])).tolist()
        with self._lock:
            rows, columns = self._slices(row, top, column, right)
            states, echoes = _states(self._evidence[rows, columns]), self._echoes[rows, columns].astype(float)
            first, movers = self._corner.tolist(), self._moving
            revision = self.revision if moving else self.still_revision
        padding = _padding(rows, row - first[0], top - first[0]), _padding(columns, column - first[1], right - first[1])
        if any(map(any, padding)):
            states = np.pad(states, padding, constant_values=UNKNOWN)
            echoes = np.pad(echoes, (*padding, (0, 0)))
        echoes[..., 0] += (np.arange(column, right + 1) + 0.5) * self.cell
        echoes[..., 1] += ((np.arange(row, top + 1) + 0.5) * self.cell)[:, None]
        if moving and len(movers):
            at = self.cells(movers) - (row, column)
            inside = ((at >= 0) & (at < states.shape)).all(axis=1)
            i, j = at[inside].T
            states[i, j], echoes[i, j] = OCCUPIED, movers[inside]
        return Window(states, echoes, column * self.cell, row * self.cell, self.cell, revision)

    def points(self, low: tuple[float, float], high: tuple[float, float], *, moving: bool = True) -> Array:
        """Obstacle points in a rectangle of cells, world frame [m], shape (k, 2); arguments as of `window`.

        Of what moves, all echoes in the rectangle of the two points are given.
        """
        (row, column), (top, right) = self.cells(np.array([low, high])).tolist()
        with self._lock:
            rows, columns = self._slices(row, top, column, right)
            taken = self._evidence[rows, columns] > OCCUPIED_ABOVE
            i, j = np.divmod(np.flatnonzero(taken), max(taken.shape[1], 1))  # faster than np.nonzero in two dimensions
            i, j = i + rows.start, j + columns.start
            echoes = self._echoes[i, j]
            cells = np.column_stack([i, j]) + self._corner
            movers = self._moving
        points: Array = echoes + self.centres(cells)
        if not (moving and len(movers)):
            return points
        return np.vstack([points, movers[((movers >= low) & (movers <= high)).all(axis=1)]])

    def _count_change(self) -> None:
        self.revision += 1
        self.still_revision += 1

    def _slices(self, row: int, top: int, column: int, right: int) -> tuple[slice, slice]:
        """Slices of the cells of a rectangle, last row and column included, that are in the grid."""
        bounds = zip((row, column), (top, right), self._corner.tolist(), strict=True)
        rows, columns = (
            slice(*(min(max(at - first, 0), self._count) for at in (start, last + 1))) for start, last, first in bounds
        )
        return rows, columns

    def _among(self, chosen: npt.NDArray[np.bool_], cells: Cells) -> npt.NDArray[np.bool_]:
        """Which cells are in the grid and chosen, shape (k,)."""
        flat, inside = self._flat(cells)
        inside[inside] = chosen.reshape(-1)[flat]
        return inside

    def _flat(self, cells: Cells) -> tuple[Indices, npt.NDArray[np.bool_]]:
        """Flat indices of those cells that are in the grid, and a mask of these cells."""
        rows, columns = cells[:, 0] - self._corner[0], cells[:, 1] - self._corner[1]
        inside = (rows >= 0) & (rows < self._count) & (columns >= 0) & (columns < self._count)
        flat: Indices = rows * self._count + columns
        return flat if inside.all() else flat[inside], inside


def _states(evidence: npt.NDArray[Any]) -> npt.NDArray[np.int8]:
    occupied: npt.NDArray[np.int8] = (evidence > OCCUPIED_ABOVE).view(np.int8)
    return UNKNOWN + (evidence < FREE_BELOW).view(np.int8) + 2 * occupied


def _padding(inside: slice, start: int, last: int) -> tuple[int, int]:
    """Numbers of requested rows or columns, `start` to `last` included, before and after those inside the grid."""
    before = min(max(-start, 0), last + 1 - start)
    return before, last + 1 - start - before - (inside.stop - inside.start)


def _overlap(shift: int, count: int) -> tuple[slice, slice]:
    """Slices of the overlap, in the old and in the new grid, along an axis when the grid moves by `shift` cells."""
    if shift >= 0:
        return slice(min(shift, count), count), slice(0, max(count - shift, 0))
    return slice(0, max(count + shift, 0)), slice(min(-shift, count), count)
