"""Shortest path in the robot's own map, with straight legs in any direction.

The algorithm is Lazy Theta* (Nash, Koenig and Tovey, AAAI 2010) on the eight neighbours of each cell. The parent of a
cell can be any cell in line of sight, not only a neighbour. The line of sight is verified only when the cell is
expanded. Unobserved cells count as free.
"""

from heapq import heappop, heappush
from math import dist

import numpy as np
from scipy.ndimage import distance_transform_edt, label

from rocs_bt import Pose2
from rocs_bt.knowledge import OCCUPIED
from rocs_bt.plan import NO_PATH, MapRoutePlanner, NoRoute, Point

MARGIN = 8.0  # [m] Margin of the map section around start and goal.
STEPS = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]


class AnyAngle(MapRoutePlanner):
    """Shortest path with legs in any direction through the robot's own map.

    It requires the analyser LocalMap and the robot's length and width. The hull is assumed to be aligned with the
    path; `clearance` is kept on both sides of the hull.
    """

    def search(self, grid, start: Pose2, goal: Pose2, clearance: float) -> list[Point]:
        body = self.knowledge.graph.attributes(self.knowledge.agent)
        room = 0.5 * min(body.get("length", 0.0), body.get("width", 0.0)) + clearance  # inner radius of the hull
        low = tuple(min(a, b) - MARGIN for a, b in zip(start[:2], goal[:2], strict=True))
        high = tuple(max(a, b) + MARGIN for a, b in zip(start[:2], goal[:2], strict=True))
        window = grid.window(low, high, moving=self.moving)
        here, there = (_cell(window, p[:2]) for p in (start, goal))
        free = _free(window, room)
        if not free[there]:
            raise NoRoute("the goal is too near to an obstacle on the map")
        free[here] = True  # a robot that is too near to an obstacle may still drive off
        parts, _ = label(free)  # a step to a corner needs both cells beside it, so that parts meet at edges only
        cells = _search(free, here, there) if parts[here] == parts[there] else None
        if cells is None:
            raise NoRoute(NO_PATH)
        inner = [(window.x + (c + 0.5) * window.cell, window.y + (r + 0.5) * window.cell) for r, c in cells[1:-1]]
        return [start[:2], *inner, goal[:2]]


def _cell(window, point):
    return int((point[1] - window.y) // window.cell), int((point[0] - window.x) // window.cell)


def _free(window, room):
    """Cells that are farther than `room` [m] from obstacles, shape (rows, columns)."""
    occupied = window.states == OCCUPIED
    if not occupied.any():
        return np.ones(occupied.shape, bool)
    return distance_transform_edt(~occupied) * window.cell > room


def _search(free, start, goal):
    """Find the shortest path with Lazy Theta*; returns the cells at its corners, or None without a path."""
    best, parent, done = {start: 0.0}, {start: start}, set()
    queue = [(dist(start, goal), start)]
    while queue:
        _, cell = heappop(queue)
        if cell in done:
            continue
        if not sees(free, parent[cell], cell):  # the line of sight was only assumed when the cell was queued
            steps = [n for n in _neighbours(free, cell) if n in done]
            parent[cell] = min(steps, key=lambda n: (best[n] + dist(n, cell), n))
            best[cell] = best[parent[cell]] + dist(parent[cell], cell)
        done.add(cell)
        if cell == goal:
            return _chain(parent, goal)
        via = parent[cell]
        for other in _neighbours(free, cell):
            length = best[via] + dist(via, other)
            if other not in done and length < best.get(other, np.inf):
                best[other], parent[other] = length, via
                heappush(queue, (length + dist(other, goal), other))
    return None


def _neighbours(free, cell):
    rows, columns = free.shape
    for i, j in STEPS:
        r, c = cell[0] + i, cell[1] + j
        if 0 <= r < rows and 0 <= c < columns and free[r, c] and free[cell[0], c] and free[r, cell[1]]:
            yield r, c


def sees(free, a, b):
    """Whether the straight line between the centres of two cells crosses free cells only."""
    (r, c), rows, columns = a, abs(b[0] - a[0]), abs(b[1] - a[1])
    up, right = (1 if b[0] > r else -1), (1 if b[1] > c else -1)
    lead = rows - columns  # positive if the line crosses the border between two rows first
    while (r, c) != b:
        if not free[r, c]:
            return False
        if lead == 0 and not (free[r + up, c] and free[r, c + right]):
            return False  # no path through a corner between two cells, because hulls have a width
        if lead >= 0:
            r += up
        if lead <= 0:
            c += right
        lead += 2 * rows * (lead <= 0) - 2 * columns * (lead >= 0)
    return bool(free[b])


def _chain(parent, goal):
    cells = [goal]
    while parent[cells[-1]] != cells[-1]:
        cells.append(parent[cells[-1]])
    return cells[::-1]
