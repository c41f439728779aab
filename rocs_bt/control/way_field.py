"""WayField: gaps to obstacles that do not move, and the way that is left to a goal, on a grid around a robot."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from .footprint import Footprint
from .locomotion import Array

CELL = 0.05
"""Side of a cell of the gaps [m]."""

COARSE = 4
"""Side of a cell of the way [cells of the gaps]."""

FAR = 60.0
"""Way from cells from which there is none [m]."""

EASE = 0.6
"""Gap from obstacles beyond which a metre of the way costs no more than its length [m]."""

STANDING = 6.0
"""Additional cost of a metre through stationary movers [m]: they may go, so they close no way."""

BESIDE = 0.15
"""Distance from a planned route within which the way is open whatever the coarse grid says [m]."""


class WayField:
    """Static gaps and the way to a goal in a square around a robot.

    Args:
        centre: Centre of the square, world frame, shape (2,) [m].
        reach: Half the side of the square [m].
        points: Obstacle points, world frame, shape (k, 2) [m].
        hull: Outline of the robot.
    """

    def __init__(self, centre: Array, reach: float, points: Array, hull: Footprint) -> None:
        from scipy.ndimage import distance_transform_edt

        around = math.ceil(reach / (CELL * COARSE))
        side = (2 * around + 1) * COARSE  # the robot is in the middle of a cell, so that left and right are alike
        self._low = centre - (around + 0.5) * CELL * COARSE
        cells = ((points - self._low) / CELL).astype(np.intp)
        cells = cells[((cells >= 0) & (cells < side)).all(axis=1)]
        free = np.ones((side, side), bool)
        free[cells[:, 1], cells[:, 0]] = False
        self._gap: Array = (
            distance_transform_edt(free) * CELL - 0.5 * CELL if len(cells) else np.full((side, side), reach)
        )
        self._end = centre
        self._way: Array = np.zeros((side // COARSE, side // COARSE))
        # Discs in a row along the longer axis cover the hull.
        long, short = max(hull.length, hull.width), min(hull.length, hull.width)
        count = max(math.ceil(long / short - 1e-9), 2)
        part = long / (2 * count)
        row = [(2 * k + 1) * part - 0.5 * long for k in range(count)]
        self._discs = [(at, 0.0) if hull.length >= hull.width else (0.0, at) for at in row]
        self._radius = math.hypot(part, 0.5 * short)
        self._half = 0.5 * hull.width  # what the hull needs on either side as it drives

    def lead(self, route: Array, standing: Array) -> None:
        """Compute the way to the end of a route.

        Args:
            route: Points of a route that the hull fits, from the robot on, world frame, shape (k, 2), k > 0 [m].
            standing: x, y and radius of stationary movers, shape (m, 3) [m]. The way leads around them.
        """
        from scipy.sparse.csgraph import dijkstra

        side, cell = len(self._way), COARSE * CELL
        gap = self._gap[COARSE // 2 :: COARSE, COARSE // 2 :: COARSE].copy()
        crowded = np.full((side, side), math.inf)
        x = self._low[0] + (np.arange(side) + 0.5) * cell
        y = self._low[1] + (np.arange(side) + 0.5) * cell
        for at_x, at_y, radius in standing.tolist():
            np.minimum(crowded, np.hypot(x - at_x, y[:, None] - at_y) - radius, out=crowded)
        route = self._inside(_spaced(route, 0.5 * cell))
        for at_x, at_y in route.tolist():
            row, column = self._cell(at_x, at_y)
            beside = slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2)
            near = np.hypot(x[beside[1]] - at_x, y[beside[0], None] - at_y) < BESIDE
            open_gap = self._gap[COARSE // 2 :: COARSE, COARSE // 2 :: COARSE][beside]
            gap[beside] = np.where(near & (open_gap <= EASE), np.maximum(gap[beside], self._half + 0.1), gap[beside])
        cost = np.where(gap > self._half + 0.06, 1.0 + 2.0 * np.clip(EASE - gap, 0.0, EASE), math.inf)
        cost += np.where(crowded > self._half + 0.06, 2.0 * np.clip(EASE - crowded, 0.0, EASE), STANDING)
        self._end = route[-1]
        goal = self._cell(*self._end.tolist())
        cost[goal] = min(cost[goal], 3.0 + STANDING)
        found = dijkstra(_graph(cost, cell), directed=False, indices=goal[0] * side + goal[1]).reshape(side, side)
        self._way = np.where(np.isfinite(found), found, FAR)

    def gaps(self, x: Array, y: Array, c: Array, s: Array) -> Array:
        """Gaps between the hull and the obstacles [m], of the shape of the arguments.

        They are too small by a few centimetres beside the longer sides, and by up to a third of the shorter side
        before the others.

        Args:
            x: Positions along x, world frame [m].
            y: Positions along y [m].
            c: Cosines of the yaws.
            s: Sines of the yaws.
        """
        side = len(self._gap) - 1
        u, v = (x - self._low[0]) / CELL, (y - self._low[1]) / CELL
        found: list[Array] = []
        for ahead, aside in self._discs:
            column = (u + (ahead * c - aside * s) / CELL).astype(np.intp)
            row = (v + (ahead * s + aside * c) / CELL).astype(np.intp)
            found.append(self._gap[row.clip(0, side), column.clip(0, side)])
        gaps: Array = np.minimum.reduce(found) - self._radius
        return gaps

    def to_go(self, x: Array, y: Array) -> Array:
        """Way that is left from n points, shape (n,) [m], interpolated between cells."""
        side, cell = len(self._way), COARSE * CELL
        u, v = (x - self._low[0]) / cell - 0.5, (y - self._low[1]) / cell - 0.5
        j, i = u.astype(np.intp).clip(0, side - 2), v.astype(np.intp).clip(0, side - 2)
        right, up = (u - j).clip(0.0, 1.0), (v - i).clip(0.0, 1.0)
        corners = np.stack([self._way[i, j], self._way[i, j + 1], self._way[i + 1, j], self._way[i + 1, j + 1]])
        np.minimum(corners, corners.min(axis=0) + 2.0, out=corners)  # a cell without a way is no cliff
        way: Array = (corners[0] * (1.0 - right) + corners[1] * right) * (1.0 - up)
        way += (corners[2] * (1.0 - right) + corners[3] * right) * up
        # Near the end the distance is exact: it is seldom the middle of a cell.
        away = np.hypot(x - self._end[0], y - self._end[1])
        share = np.minimum(away / (2.0 * cell), 1.0)
        exact: Array = share * way + (1.0 - share) * away
        return exact

    def _cell(self, x: float, y: float) -> tuple[int, int]:
        side, cell = len(self._way), COARSE * CELL
        row, column = int((y - self._low[1]) / cell), int((x - self._low[0]) / cell)
        return min(max(row, 0), side - 1), min(max(column, 0), side - 1)

    def _inside(self, route: Array) -> Array:
        """Part of a route up to the border of the square, at least one point."""
        size = len(self._gap) * CELL
        outside = ((route < self._low) | (route > self._low + size)).any(axis=1)
        return route[: max(int(outside.argmax()), 1)] if outside.any() else route


def _spaced(route: Array, step: float) -> Array:
    """Points at most a step [m] apart on a polyline (k, 2)."""
    if len(route) < 2:
        return route
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(route, axis=0).T))])
    at = np.append(np.arange(0.0, along[-1], step), along[-1])
    return np.column_stack([np.interp(at, along, route[:, 0]), np.interp(at, along, route[:, 1])])


def _graph(cost: Array, cell: float) -> object:
    """Sparse graph of the cells with finite cost and their eight neighbours; weights in metres of the way."""
    from scipy.sparse import coo_matrix

    first, second, far = _edges(*cost.shape)
    flat = cost.reshape(-1)
    weights = 0.5 * (flat[first] + flat[second]) * (far * cell)
    kept = np.isfinite(weights)
    return coo_matrix((weights[kept], (first[kept], second[kept])), shape=(flat.size, flat.size)).tocsr()


@lru_cache(maxsize=4)
def _edges(rows: int, columns: int) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Array]:
    """Cells at both ends of each edge between neighbours, and its length [cells]."""
    number = np.arange(rows * columns).reshape(rows, columns)
    first, second, far = [], [], []
    for up, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        low, high = max(0, -right), columns - max(0, right)
        a, b = number[: rows - up, low:high], number[up:, low + right : high + right]
        first.append(a.reshape(-1))
        second.append(b.reshape(-1))
        far.append(np.full(a.size, math.hypot(up, right)))
    return np.concatenate(first), np.concatenate(second), np.concatenate(far)
