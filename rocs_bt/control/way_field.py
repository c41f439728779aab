"""WayField: gaps to obstacles that do not move, and the way that is left to a goal, on a grid around a robot."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from .footprint import Footprint
from .locomotion import Array

if TYPE_CHECKING:
    from scipy.sparse import csr_array


CELL = 0.05
"""Side of a cell of the gaps [m]."""

FINE = 0.15
"""Greatest distance of the centres of discs that cover the hull finely [m]."""

COARSE = 4
"""Side of a cell of the way [cells of the gaps]."""

FAR = 60.0
"""Way from cells from which there is none [m]."""

EASE = 0.6
"""Gap from obstacles beyond which a metre of the way costs no more than its length [m]."""

STANDING = 6.0
"""Additional cost of a metre through stationary movers [m]: they may go, so they close no way."""

USED = 0.3
"""Gap of the hull up to which gaps are exact; greater ones are too small [m]."""

BESIDE = 0.15
"""Distance from a planned route within which the way is open whatever the coarse grid says [m]."""

_AROUND = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])


class _Discs(NamedTuple):
    """Discs that cover a hull: their centres, body frame, and their radius [m]."""

    centres: list[tuple[float, float]]
    radius: float

    @staticmethod
    def of(hull: Footprint, rows: int, columns: int) -> _Discs:
        """Discs in a number of rows along the length, and columns along the width."""
        ahead, aside = hull.length / (2 * rows), hull.width / (2 * columns)
        centres = [
            ((2 * i + 1 - rows) * ahead, (2 * j + 1 - columns) * aside) for i in range(rows) for j in range(columns)
        ]
        return _Discs(centres, math.hypot(ahead, aside))


class WayField:
    """Static gaps and the way to a goal in a square around a robot.

    Args:
        centre: Centre of the square, world frame, shape (2,) [m].
        reach: Half the side of the square [m].
        points: Obstacle points, world frame, shape (k, 2) [m].
        hull: Outline of the robot.
    """

    def __init__(self, centre: Array, reach: float, points: Array, hull: Footprint) -> None:
        around = math.ceil(reach / (CELL * COARSE))
        side = (2 * around + 1) * COARSE  # the robot is in the middle of a cell, so that left and right are alike
        self._low = centre - (around + 0.5) * CELL * COARSE
        self._end = centre
        self._way: Array = np.zeros((side // COARSE, side // COARSE))
        self._corners = _corners(self._way)
        long, short = max(hull.length, hull.width), min(hull.length, hull.width)
        row = max(math.ceil(long / short - 1e-9), 2)
        self._discs = _Discs.of(hull, *((row, 1) if hull.length >= hull.width else (1, row)))
        self._fine = _Discs.of(hull, math.ceil(hull.length / FINE), math.ceil(hull.width / FINE))
        self._half = 0.5 * hull.width  # what the hull needs on either side as it drives
        cells = ((points - self._low) / CELL).astype(np.intp)
        cells = cells[((cells >= 0) & (cells < side)).all(axis=1)]
        taken = np.zeros((side, side), bool)
        taken[cells[:, 1], cells[:, 0]] = True
        far = math.ceil((max(EASE, self._half + 0.1, self._discs.radius + USED)) / CELL) + 1
        self._gap: Array = distances(taken, far) * CELL - 0.5 * CELL

    def lead(self, route: Array, standing: Array) -> None:
        """Compute the way to the end of a route.

        Args:
            route: Points of a route that the hull fits, from the robot on, world frame, shape (k, 2), k > 0 [m].
            standing: x, y and radius of stationary movers, shape (m, 3) [m]. The way leads around them.
        """
        from scipy.sparse.csgraph import dijkstra

        side, cell = len(self._way), COARSE * CELL
        gap = self._gap[COARSE // 2 :: COARSE, COARSE // 2 :: COARSE]
        crowded = np.full((side, side), math.inf)
        x, y = (low + (np.arange(side) + 0.5) * cell for low in self._low)
        for at_x, at_y, radius in standing.tolist():
            np.minimum(crowded, np.hypot(x - at_x, y[:, None] - at_y) - radius, out=crowded)
        route = self._inside(_spaced(route, 0.5 * cell))
        opened = self._beside(route) & (gap <= EASE)
        gap = np.where(opened, np.maximum(gap, self._half + 0.1), gap)
        cost = np.where(gap > self._half + 0.06, 1.0 + 2.0 * np.clip(EASE - gap, 0.0, EASE), math.inf)
        cost += np.where(crowded > self._half + 0.06, 2.0 * np.clip(EASE - crowded, 0.0, EASE), STANDING)
        self._end = route[-1]
        goal = self._cell(*self._end.tolist())
        cost[goal] = min(cost[goal], 3.0 + STANDING)
        found = dijkstra(grid_graph(cost), indices=goal[0] * side + goal[1]).reshape(side, side)
        self._way = np.where(np.isfinite(found), found * cell, FAR)
        self._corners = _corners(self._way)

    def gap(self, x: Array, y: Array) -> Array:
        """Distances of points from the nearest obstacle, world frame, of the shape of the arguments [m]."""
        last = len(self._gap) - 1
        column, row = ((x - self._low[0]) / CELL).astype(np.intp), ((y - self._low[1]) / CELL).astype(np.intp)
        gap: Array = self._gap[row.clip(0, last), column.clip(0, last)]
        return gap

    def gaps(self, x: Array, y: Array, c: Array, s: Array, *, fine: bool = False) -> Array:
        """Gaps between the hull and the obstacles [m], of the shape of the arguments.

        They are too small by a few centimetres beside the longer sides, and by up to a third of the shorter side
        before the others; by less than 0.1 m everywhere if they are `fine`, which takes longer.

        Gaps above `USED` may be much too small.

        Args:
            x: Positions along x, world frame [m].
            y: Positions along y [m].
            c: Cosines of the yaws.
            s: Sines of the yaws.
            fine: Whether they are needed close to obstacles.
        """
        side, discs = len(self._gap), self._fine if fine else self._discs
        u, v = (x - self._low[0]) / CELL, (y - self._low[1]) / CELL
        found: list[Array] = []
        for ahead, aside in discs.centres:
            column = (u + (ahead * c - aside * s) / CELL).astype(np.intp)
            row = (v + (ahead * s + aside * c) / CELL).astype(np.intp)
            np.minimum(np.maximum(column, 0, out=column), side - 1, out=column)
            np.minimum(np.maximum(row, 0, out=row), side - 1, out=row)
            row *= side
            row += column
            found.append(self._gap.take(row))
        gaps: Array = np.minimum.reduce(found) - discs.radius
        return gaps

    def to_go(self, x: Array, y: Array) -> Array:
        """Way that is left from points [m], interpolated between cells, of the shape of the arguments."""
        squares, cell = len(self._way) - 1, COARSE * CELL
        u, v = (x - self._low[0]) / cell - 0.5, (y - self._low[1]) / cell - 0.5
        j, i = (np.minimum(np.maximum(at.astype(np.intp), 0), squares - 1) for at in (u, v))
        right, up = (np.minimum(np.maximum(at, 0.0), 1.0) for at in (u - j, v - i))
        corners = self._corners.take(i * squares + j, axis=1)
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

    def _beside(self, route: Array) -> npt.NDArray[np.bool_]:
        """Cells of the way with centres nearer than `BESIDE` to a route inside the square, shape (side, side)."""
        side, cell = len(self._way), COARSE * CELL
        around = np.clip(((route - self._low) / cell).astype(np.intp), 0, side - 1)[:, None] + _AROUND
        at = self._low + (around + 0.5) * cell
        near = np.hypot(*(at - route[:, None]).transpose(2, 0, 1)) < BESIDE
        column, row = around[near & ((around >= 0) & (around < side)).all(axis=-1)].T
        beside = np.zeros((side, side), bool)
        beside[row, column] = True
        return beside

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


def _corners(way: Array) -> Array:
    """Values at the corners of the squares between the centres of four cells, shape (4, squares)."""
    corners = np.stack([way[:-1, :-1], way[:-1, 1:], way[1:, :-1], way[1:, 1:]]).reshape(4, -1)
    clipped: Array = np.minimum(corners, corners.min(axis=0) + 2.0)  # a cell without a way is no cliff
    return clipped


def distances(taken: npt.NDArray[np.bool_], far: int) -> Array:
    """Distances of the cells of a grid to the nearest taken cell, at most `far` [cells], between their centres.

    Two passes, along rows and then along columns: Saito and Toriwaki, New algorithms for Euclidean distance
    transformation of an n-dimensional digitized picture with applications, Pattern Recognition 27, 1994.
    """
    columns = np.arange(taken.shape[1], dtype=np.int16)
    west = np.maximum.accumulate(np.where(taken, columns, np.int16(-far - 1)), axis=1)
    east = np.minimum.accumulate(np.where(taken, columns, np.int16(len(columns) + far))[:, ::-1], axis=1)[:, ::-1]
    along = np.minimum(np.minimum(columns - west, east - columns), np.int16(far))
    along *= along
    square = along.copy()
    for k in range(1, far):
        there = along + np.int16(k * k)
        np.minimum(square[k:], there[:-k], out=square[k:])
        np.minimum(square[:-k], there[k:], out=square[:-k])
    found: Array = np.sqrt(np.minimum(square, np.int16(far * far)).astype(float))
    return found


NEIGHBOURS = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))
"""Rows and columns from a cell to its neighbours."""

LEGS = [math.hypot(*step) for step in NEIGHBOURS]


def grid_graph(cost: Array, guess: Array | None = None) -> csr_array:
    """Graph of all cells, row by row; an edge costs its length in cells times the mean cost of both cells.

    Args:
        cost: Cost of each cell, shape (rows, columns); +inf closes a cell.
        guess: Lower bound of the cost from each cell to the goal, shape (rows, columns). If given, edges are reduced by
            its decrease, so that Dijkstra's algorithm acts as A*.
    """
    from scipy.sparse import csr_array

    rows, columns = cost.shape
    near, starts = _neighbours(rows, columns)
    around = np.pad(cost, 1, constant_values=math.inf)
    weights = np.empty((rows, columns, len(NEIGHBOURS)))
    bound = np.zeros_like(cost) if guess is None else guess
    ahead = np.pad(bound, 1)
    for k, (i, j) in enumerate(NEIGHBOURS):
        part = slice(1 + i, 1 + i + rows), slice(1 + j, 1 + j + columns)
        weights[:, :, k] = (0.5 * LEGS[k]) * (cost + around[part]) + (ahead[part] - bound)
    np.maximum(weights, 1e-9, out=weights)  # rounding may give negative values; a zero would be no edge
    return csr_array((weights.reshape(-1), near, starts), shape=(cost.size, cost.size))


@lru_cache(maxsize=16)
def _neighbours(rows: int, columns: int) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Column indices and row starts of the sparse adjacency matrix of a grid's cells.

    A neighbour outside the grid is replaced by the cell itself, at infinite cost.
    """
    own = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    padded = np.pad(own, 1, constant_values=-1)
    near = np.stack([padded[1 + i : 1 + i + rows, 1 + j : 1 + j + columns] for i, j in NEIGHBOURS], axis=-1)
    near = np.where(near < 0, own[:, :, None], near)
    starts = np.arange(0, len(NEIGHBOURS) * own.size + 1, len(NEIGHBOURS), dtype=np.int32)
    return near.reshape(-1), starts
