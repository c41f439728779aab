"""FreeGround: squares of ground, and when each was last known to be free."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..geometry import Pose2

Array = npt.NDArray[np.float64]

Frame = tuple[float, float, float, float]
"""A frame on a map, in squares: where its origin is, and cosine and sine of its yaw."""


class FreeGround:
    """A map that goes with the robot; what is left behind is forgotten.

    Args:
        cell: Side of a square [m].
        size: Squares along a side of the map.
    """

    def __init__(self, cell: float = 0.1, size: int = 96) -> None:
        self.cell = cell
        self._size = size
        self._free = np.full((size, size), -math.inf)  # when [s]
        self._corner = (0, 0)  # the square that is the map's first

    def centre(self, pose: Pose2) -> None:
        """Keep the robot in the map's middle half."""
        here = math.floor(pose.x / self.cell), math.floor(pose.y / self.cell)
        quarter = self._size // 4
        if all(quarter <= at - first < 3 * quarter for at, first in zip(here, self._corner, strict=True)):
            return
        corner = here[0] - self._size // 2, here[1] - self._size // 2
        dx, dy = corner[0] - self._corner[0], corner[1] - self._corner[1]
        moved = np.full_like(self._free, -math.inf)
        if abs(dx) < self._size and abs(dy) < self._size:
            kept = self._free[max(dx, 0) : self._size + min(dx, 0), max(dy, 0) : self._size + min(dy, 0)]
            moved[max(-dx, 0) :, max(-dy, 0) :][: kept.shape[0], : kept.shape[1]] = kept
        self._free, self._corner = moved, corner

    def mark(self, at: Pose2, points: Array, t: float) -> None:
        """Ground was free at a time [s], at points (k, 2) of a frame [m]; at -inf, it is not known to be."""
        mark_at(self._free, self._frame(at), points, t)

    def strides(self, at: Pose2, ways: Array, since: float) -> list[int]:
        """(n,) So many strides of each way were known to be free, no longer ago than a time [s].

        Args:
            at: A frame.
            ways: (n, k, m, 2) Of each way, after each stride, some points of that frame [m].
            since: Until when back.
        """
        return strides_at(self._free, self._frame(at), ways, since)

    def _frame(self, at: Pose2) -> Frame:
        x, y = at.x / self.cell - self._corner[0], at.y / self.cell - self._corner[1]
        return x, y, math.cos(at.yaw) / self.cell, math.sin(at.yaw) / self.cell


def mark_at(ground: Array, frame: Frame, points: Array, t: float) -> None:
    """Write a time [s] into the squares (n, n) that points (k, 2) of a frame are in; those off the map do not count."""
    squares, inside = _squares(len(ground), frame, points)
    ground.put(squares[inside], t)


def strides_at(ground: Array, frame: Frame, ways: Array, since: float) -> list[int]:
    """Find how many strides of each way come before the first that is not free.

    Args:
        ground: (s, s) When each square was last known to be free [s].
        frame: What the ways are given in.
        ways: (n, k, m, 2) After each of k strides, m points, which must all be on the map.
        since: How lately they must be known to be free [s].
    """
    squares, inside = _squares(len(ground), frame, ways)
    free = np.logical_and.reduce((ground.take(squares, mode="clip") >= since) & inside, axis=2)
    return [way.index(False) if False in way else len(way) for way in free.tolist()]


def _squares(size: int, frame: Frame, points: Array) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]:
    """(...) The squares that points (..., 2) are in, counted row by row, and whether they are on the map."""
    (at_x, at_y, c, s), x, y = frame, points[..., 0], points[..., 1]
    ix, iy = np.floor(at_x + c * x - s * y).astype(np.int64), np.floor(at_y + s * x + c * y).astype(np.int64)
    inside = (ix.view(np.uint64) < size) & (iy.view(np.uint64) < size)  # without a sign a negative one is very large
    return ix * size + iy, inside
