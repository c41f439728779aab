"""FloorGrid: ground-truth occupancy of a floor, and shortest paths over its free cells."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .obstacle import Block, Point, Post, length_of

Cell = tuple[int, int]
Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class GridPath:
    """Path on a grid: corners, length and minimum clearance [m]."""

    points: tuple[Point, ...]
    length: float
    clearance: float


@dataclass(frozen=True)
class FloorGrid:
    """Ground-truth occupancy of a floor; an `OccupancyGrid`, in contrast, is sensed by a robot.

    Attributes:
        occupied: Whether each cell is occupied, shape (rows, columns); row 0 has the lowest y, column 0 the lowest x.
        cell: Side of a cell [m].
        low: Outer corner of the cell in row 0, column 0 [m].
    """

    occupied: Mask
    cell: float
    low: Point

    def add(self, obstacle: Post | Block) -> None:
        """Mark the cells with centres inside an obstacle."""
        reach = obstacle.radius if isinstance(obstacle, Post) else math.hypot(obstacle.length, obstacle.width) / 2
        rows, columns = (self._range(v, reach, axis) for axis, v in ((1, obstacle.y), (0, obstacle.x)))
        y, x = np.meshgrid(self._centres(rows, 1) - obstacle.y, self._centres(columns, 0) - obstacle.x, indexing="ij")
        if isinstance(obstacle, Post):
            inside = x * x + y * y <= obstacle.radius**2
        else:
            c, s = math.cos(obstacle.yaw), math.sin(obstacle.yaw)
            inside = (abs(c * x + s * y) <= obstacle.length / 2) & (abs(c * y - s * x) <= obstacle.width / 2)
        self.occupied[rows, columns] |= inside

    def clearances(self) -> Array:
        """Distance from each cell's centre to that of the nearest occupied cell [m], shape (rows, columns)."""
        from scipy.ndimage import distance_transform_edt

        if not self.occupied.any():
            return np.full(self.occupied.shape, math.inf)
        return np.asarray(distance_transform_edt(~self.occupied), dtype=np.float64) * self.cell

    def shortest(self, start: Point, goal: Point, radius: float) -> GridPath | None:
        """Shortest path of a disc with a radius [m], exact to one cell; None if there is none.

        The path is found by Dijkstra's algorithm (compiled) on the 8-connected grid, and shortened along lines of
        sight. If start or goal is too near to an obstacle for the disc, the search uses the nearest free cell.
        """
        clearances = self.clearances()
        free = clearances > radius
        found = (
            shortest_cells(free, self._nearest(free, start), self._nearest(free, goal), self.cell)
            if free.any()
            else None
        )
        if found is None:
            return None
        corners = [self.centre(row, column) for row, column in _without_visible(found, free)]
        points = (start, *corners[1:-1], goal)
        return GridPath(points, length_of(points), float(min(clearances[row, column] for row, column in found)))

    def blocks(self, name: str = "wall") -> list[Post | Block]:
        """Boxes that cover exactly the occupied cells. Equal runs of occupied cells in successive rows form one box."""
        open_: dict[tuple[int, int], int] = {}  # first row of each open run, by its first and last column
        found: list[tuple[int, int, int, int]] = []
        for row in range(self.occupied.shape[0] + 1):
            here = set(_runs(self.occupied[row])) if row < self.occupied.shape[0] else set()
            found += [(*run, first, row) for run, first in open_.items() if run not in here]
            open_ = {run: open_.get(run, row) for run in sorted(here)}
        (x, y), cell = self.low, self.cell
        return [
            Block(f"{name}_{i}", x + cell * (a + b) / 2.0, y + cell * (c + d) / 2.0, cell * (b - a), cell * (d - c))
            for i, (a, b, c, d) in enumerate(found)
        ]

    def centre(self, row: int, column: int) -> Point:
        """Centre of a cell [m]."""
        return self.low[0] + (column + 0.5) * self.cell, self.low[1] + (row + 0.5) * self.cell

    def cell_at(self, point: Point) -> Cell:
        """Row and column of the cell that contains a point [m]; the nearest cell for points outside."""
        rows, columns = self.occupied.shape
        row, column = (math.floor((point[axis] - self.low[axis]) / self.cell) for axis in (1, 0))
        return min(max(row, 0), rows - 1), min(max(column, 0), columns - 1)

    def _nearest(self, free: Mask, point: Point) -> Cell:
        rows, columns = np.nonzero(free)
        x, y = self.low[0] + (columns + 0.5) * self.cell, self.low[1] + (rows + 0.5) * self.cell
        best = int(np.argmin((x - point[0]) ** 2 + (y - point[1]) ** 2))
        return int(rows[best]), int(columns[best])

    def _range(self, centre: float, reach: float, axis: int) -> slice:
        size = self.occupied.shape[1 - axis]
        first, last = (math.floor((centre + d - self.low[axis]) / self.cell) for d in (-reach, reach))
        return slice(min(max(first, 0), size), min(max(last + 1, 0), size))

    def _centres(self, cells: slice, axis: int) -> Array:
        return self.low[axis] + (np.arange(cells.start, cells.stop) + 0.5) * self.cell


def shortest_cells(
    free: Mask, start: Cell, goal: Cell, cell: float, extra_cost: Array | None = None
) -> list[Cell] | None:
    """Cells of a shortest path on the 8-connected grid, found by Dijkstra's algorithm (compiled).

    Args:
        free: Whether each cell may be used, shape (rows, columns).
        start: Row and column of the start, a free cell.
        goal: Row and column of the goal, a free cell.
        cell: Side of a cell [m].
        extra_cost: Cost of each cell in addition to the step length [m], shape (rows, columns). A step adds the mean of
            the costs of its two cells.

    Returns:
        Row and column of each cell from start to goal; None if there is no path.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    ids = np.full(free.shape, -1, dtype=np.int64)
    rows, columns = np.nonzero(free)
    ids[rows, columns] = np.arange(len(rows))
    heads, tails, costs = [], [], []
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        r, c = rows + down, columns + right
        inside = (r < free.shape[0]) & (c >= 0) & (c < free.shape[1])
        there = ids[r[inside], c[inside]]
        here = ids[rows[inside], columns[inside]]
        heads.append(here[there >= 0])
        tails.append(there[there >= 0])
        paid = (
            0.0
            if extra_cost is None
            else 0.5 * (extra_cost[rows, columns][inside] + extra_cost[r[inside], c[inside]])[there >= 0]
        )
        costs.append(np.full(int((there >= 0).sum()), cell * math.hypot(down, right)) + paid)
    shape = (len(rows), len(rows))
    graph = coo_matrix((np.concatenate(costs), (np.concatenate(heads), np.concatenate(tails))), shape=shape).tocsr()
    first, last = int(ids[start]), int(ids[goal])
    away, before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)
    if not math.isfinite(away[last]):
        return None
    path = [last]
    while path[-1] != first:
        path.append(int(before[path[-1]]))
    return [(int(rows[i]), int(columns[i])) for i in reversed(path)]


def _runs(row: Mask) -> list[tuple[int, int]]:
    """First column and one past the last column of each run of occupied cells."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(np.int8))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def _without_visible(path: Sequence[Cell], free: Mask) -> list[Cell]:
    """Remove the cells of a path that a straight line through free cells can skip."""
    kept, last = [path[0]], 0
    while last < len(path) - 1:
        low, high = last + 1, len(path) - 1
        if not _sees(path[last], path[high], free):
            while low < high - 1:  # visibility is nearly monotone along a shortest path
                middle = (low + high) // 2
                low, high = (middle, high) if _sees(path[last], path[middle], free) else (low, middle)
            high = low
        kept.append(path[high])
        last = high
    return kept


def _sees(a: Cell, b: Cell, free: Mask) -> bool:
    count = 2 * max(abs(a[0] - b[0]), abs(a[1] - b[1])) + 1
    rows = np.rint(np.linspace(a[0], b[0], count)).astype(int)
    columns = np.rint(np.linspace(a[1], b[1], count)).astype(int)
    return bool(free[rows, columns].all())
