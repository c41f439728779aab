"""Spatial index of nodes for nearest-neighbour queries.

The index is a hash grid of square cells. The cell side depends on the number and the density of the points, so that an
occupied cell holds about two points. A search visits rings of cells around a point and stops when no farther ring can
hold a nearer point (J. L. Bentley, B. W. Weide, A. C. Yao, "Optimal Expected-Time Algorithms for Closest Point
Problems", 1980).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

Batch = list[tuple[float, str]]
Cell = tuple[int, int]

_FULL = 2.0  # target number of points in an occupied cell
_SAMPLE = 512  # number of points sampled to choose the side of the cells
_SHORTEST, _LONGEST = 1e-3, 1e6  # side of a cell [m]
_FAR = 1e9  # points beyond this coordinate are kept outside the cells [m]


class SpatialIndex:
    """Named points in the plane, searchable by distance."""

    def __init__(self) -> None:
        self._side = 1.0
        self._points: dict[str, tuple[float, float]] = {}
        self._home: dict[str, Cell | None] = {}  # cell of each point; None for points beyond _FAR
        self._cells: dict[Cell, dict[str, tuple[float, float]]] = {}
        self._far: dict[str, tuple[float, float]] = {}
        self._built = 32  # number of points for which the side was chosen; at least 32

    def __len__(self) -> int:
        return len(self._points)

    def put(self, name: str, x: float, y: float) -> None:
        """Add a point, or move it [m]."""
        side = self._side
        cell = (math.floor(x / side), math.floor(y / side)) if abs(x) <= _FAR and abs(y) <= _FAR else None
        if name in self._points and self._home[name] != cell:
            self._remove_from_cell(name)
        self._points[name] = point = (x, y)
        self._home[name] = cell
        if cell is None:
            self._far[name] = point
            return
        try:
            self._cells[cell][name] = point
        except KeyError:
            self._cells[cell] = {name: point}
        if len(self._points) > 2 * self._built:
            self._build()

    def drop(self, name: str) -> None:
        """Remove a point; an unknown name is ignored."""
        if name in self._points:
            self._remove_from_cell(name)
            del self._points[name], self._home[name]

    def rings(self, x: float, y: float, within: float = math.inf) -> Iterator[Batch]:
        """Points around (x, y) in batches of (distance [m], name), sorted by distance within and across batches.

        Points may be added, removed and moved between two batches; such a point may be missed or reported twice.
        """
        if not (abs(x) <= _FAR and abs(y) <= _FAR) or not self._points:
            yield sorted(_measured(self._points.items(), x, y, within))
            return
        side, cells, hypot = self._side, self._cells, math.hypot
        u, v = math.floor(x / side), math.floor(y / side)
        border = min(x - u * side, (u + 1) * side - x, y - v * side, (v + 1) * side - y)
        waiting = _measured(self._far.items(), x, y, within) if self._far else []
        ring, looked = 1, 0
        while looked <= len(cells) and ring * side <= within + side:
            for cell in _ring(u, v, ring):
                if (points := cells.get(cell)) is not None:
                    for name, (px, py) in points.items():
                        if (distance := hypot(px - x, py - y)) <= within:
                            waiting.append((distance, name))
            # Rounding can put a point on a border into the next cell, so the safe radius is slightly smaller.
            safe = (border + ring * side) * (1.0 - 1e-9)
            if waiting:
                waiting.sort()
                if waiting[0][0] < safe:
                    ready = [found for found in waiting if found[0] < safe]
                    waiting = waiting[len(ready) :]
                    yield ready
            looked += 8 * ring + (ring == 1)
            ring += 1
        if ring * side <= within + side:  # fewer cells are left than rings would ask for
            for (a, b), points in [*cells.items()]:
                if max(abs(a - u), abs(b - v)) >= ring:
                    waiting += _measured([*points.items()], x, y, within)
        yield sorted(waiting)

    def _remove_from_cell(self, name: str) -> None:
        cell = self._home[name]
        if cell is None:
            del self._far[name]
            return
        points = self._cells[cell]
        del points[name]
        if not points:
            del self._cells[cell]

    def _build(self) -> None:
        """Choose a new cell side and distribute all points to new cells; a running search keeps the old cells."""
        self._built = len(self._points)
        near = {name: point for name, point in self._points.items() if self._home[name] is not None}
        self._side = side = _chosen_side([*near.values()])
        cells: dict[Cell, dict[str, tuple[float, float]]] = {}
        for name, point in near.items():
            cell = self._home[name] = math.floor(point[0] / side), math.floor(point[1] / side)
            cells.setdefault(cell, {})[name] = point
        self._cells = cells


def _measured(points: Iterable[tuple[str, tuple[float, float]]], x: float, y: float, within: float) -> Batch:
    found = ((math.hypot(px - x, py - y), name) for name, (px, py) in points)
    return [(distance, name) for distance, name in found if distance <= within]


def _ring(u: int, v: int, ring: int) -> Iterable[Cell]:
    """Cells at a distance of `ring` cells from cell (u, v); ring 1 includes cell (u, v) itself."""
    if ring > 1:
        return _far_ring(u, v, ring)
    return (
        (u, v),
        (u - 1, v - 1),
        (u, v - 1),
        (u + 1, v - 1),
        (u - 1, v),
        (u + 1, v),
        (u - 1, v + 1),
        (u, v + 1),
        (u + 1, v + 1),
    )


def _far_ring(u: int, v: int, ring: int) -> Iterator[Cell]:
    for i in range(u - ring, u + ring + 1):
        yield i, v - ring
        yield i, v + ring
    for j in range(v - ring + 1, v + ring):
        yield u - ring, j
        yield u + ring, j


def _chosen_side(points: list[tuple[float, float]]) -> float:
    """Cell side [m] at which an occupied cell holds about `_FULL` points, estimated from a sample."""
    sample = points[:: max(1, len(points) // _SAMPLE)]
    side = _LONGEST
    while side > _SHORTEST and len({(x // side, y // side) for x, y in sample}) < len(sample) / _FULL:
        side /= 2.0
    # A sample of one in k points of a plane has sqrt(k) times the spacing.
    return max(_SHORTEST, side * math.sqrt(len(sample) / max(1, len(points))))
