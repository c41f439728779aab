"""FreeGround: squares of ground, and when each was last known to be free."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..geometry import Pose2

Array = npt.NDArray[np.float64]


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
        ix, iy = self._squares(at, points)
        inside = self._inside(ix, iy)
        self._free[ix[inside], iy[inside]] = t

    def free(self, at: Pose2, points: Array, since: float) -> npt.NDArray[np.bool_]:
        """Whether ground was known to be free, at points (..., 2) of a frame [m], no longer ago than a time [s]."""
        ix, iy = self._squares(at, points)
        known: npt.NDArray[np.bool_] = self._free.take(ix * self._size + iy, mode="clip") >= since
        return known & self._inside(ix, iy)

    def _inside(self, ix: npt.NDArray[np.int64], iy: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        """Whether squares are on the map; as a number without a sign a negative one is very large."""
        inside: npt.NDArray[np.bool_] = (ix.view(np.uint64) < self._size) & (iy.view(np.uint64) < self._size)
        return inside

    def _squares(self, at: Pose2, points: Array) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        c, s = math.cos(at.yaw) / self.cell, math.sin(at.yaw) / self.cell
        x, y = points[..., 0], points[..., 1]
        ix = np.floor(at.x / self.cell - self._corner[0] + c * x - s * y).astype(np.int64)
        iy = np.floor(at.y / self.cell - self._corner[1] + s * x + c * y).astype(np.int64)
        return ix, iy
