"""Map of free ground around the robot: for each square, the time at which it was last seen to be free."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rocs_bt import Pose2

Array = npt.NDArray[np.float64]

Frame = tuple[float, float, float, float]
"""Frame of points, in units of squares: x and y of its origin on the map; cosine and sine of its yaw per side."""


class FreeGround:
    """Square grid map that moves with the robot and forgets the ground outside of it.

    Args:
        cell: Side of a square [m].
        size: Number of squares along a side of the map.
    """

    def __init__(self, cell: float = 0.1, size: int = 96) -> None:
        self.cell = cell
        self._size = size
        self._free = np.full((size, size), -math.inf)  # time of the last free observation [s]
        self._corner = (0, 0)  # index of the map's first square in the world's grid

    def centre(self, pose: Pose2) -> None:
        """Move the map so that the robot is in its middle half."""
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
        """Mark ground as free.

        Args:
            at: Pose of the frame of the points, world frame.
            points: Positions on the ground in that frame [m], shape (k, 2).
            t: Time of observation [s]; -inf marks the ground as not free.
        """
        mark_at(self._free, self._frame(at), points, t)

    def strides(self, at: Pose2, paths: Array, since: float) -> list[int]:
        """Number of strides (short steps of equal length) of each path before the first one that is not free.

        Args:
            at: Pose of the frame of the paths, world frame.
            paths: Points that the hull covers after each stride of each path, in that frame [m], shape (n, k, m, 2).
            since: Oldest time at which ground counts as free [s].
        """
        return strides_at(self._free, self._frame(at), paths, since)

    def _frame(self, at: Pose2) -> Frame:
        x, y = at.x / self.cell - self._corner[0], at.y / self.cell - self._corner[1]
        return x, y, math.cos(at.yaw) / self.cell, math.sin(at.yaw) / self.cell


def mark_at(ground: Array, frame: Frame, points: Array, t: float) -> None:
    """Write a time into the squares of some points; points off the map are ignored.

    Args:
        ground: Map that is written, shape (s, s).
        frame: Frame of the points.
        points: Positions in that frame [m], shape (k, 2).
        t: Time [s].
    """
    squares, inside = _squares(len(ground), frame, points)
    ground.put(squares[inside], t)


def strides_at(ground: Array, frame: Frame, paths: Array, since: float) -> list[int]:
    """Number of strides of each path before the first one that is not free, shape (n,).

    Args:
        ground: Time at which each square was last known to be free [s], shape (s, s).
        frame: Frame of the paths.
        paths: Points that the hull covers after each of k strides [m], shape (n, k, m, 2). A stride with a point off
            the map is not free.
        since: Oldest time at which ground counts as free [s].
    """
    squares, inside = _squares(len(ground), frame, paths)
    free = np.logical_and.reduce((ground.take(squares, mode="clip") >= since) & inside, axis=2)
    return [path.index(False) if False in path else len(path) for path in free.tolist()]


def _squares(size: int, frame: Frame, points: Array) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]:
    """Row-major index of the square of each point, and whether the point is on the map.

    Args:
        size: Number of squares along a side of the map.
        frame: Frame of the points.
        points: Positions in that frame [m], shape (..., 2). Both results have the shape (...).
    """
    (at_x, at_y, c, s), x, y = frame, points[..., 0], points[..., 1]
    ix, iy = np.floor(at_x + c * x - s * y).astype(np.int64), np.floor(at_y + s * x + c * y).astype(np.int64)
    inside = (ix.view(np.uint64) < size) & (iy.view(np.uint64) < size)  # as unsigned, a negative number is very large
    return ix * size + iy, inside
