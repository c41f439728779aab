"""Cheapest path over a state lattice: positions with a heading, connected by motions of a car-like robot.

Because the heading is part of the search, the hull is checked against the map in its actual pose, and turns have a
cost. Source: Pivtoraiko and Kelly, Efficient constrained path planning via search in state lattices (i-SAIRAS 2005);
here with eight headings, and SciPy's Dijkstra as the search. The map is the robot's own; unobserved cells count as
free.
"""

from itertools import pairwise
from math import ceil, cos, dist, hypot, inf, pi, sin

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from rocs_bt.geometry import Pose2
from rocs_bt.knowledge import OCCUPIED
from rocs_bt.plan import NO_PATH, MapRoutePlanner, NoRoute, Point, distance_to_path

SPACING = 0.2  # [m] Spacing of the lattice.
MARGIN = 3.0  # [m] Margin of the map section around start and goal.
REACH = 8.0  # [m] Maximum range of the map section around the robot.
EASE, SLOWEST = 0.5, 0.15  # [m] Clearance beyond which the speed is not reduced; fraction of it at zero clearance.
TURN = 0.4  # [m] Cost of a turn of 45 deg on the spot.
MAX_PATH_DISTANCE = 0.3  # [m] Maximum distance between the robot and its path.

STEPS = ((0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1))  # (rows, columns) by heading
HEADINGS = len(STEPS)


class Lattice(MapRoutePlanner):
    """Plans in the robot's own map; requires the analyser LocalMap and the robot's length and width."""

    def __init__(self, knowledge):
        super().__init__(knowledge)
        body = knowledge.graph.attributes(knowledge.agent)
        self._length, self._width = body.get("length", 0.4), body.get("width", 0.4)
        self._kept = None

    def search(self, grid, start: Pose2, goal: Pose2, clearance: float) -> list[Point]:
        if self._kept is not None:
            path, towards, revision = self._kept
            if towards == goal[:2] and distance_to_path(start[:2], path) < MAX_PATH_DISTANCE:
                if revision == grid.revision:
                    return path
                if _clear(grid, path, 0.5 * self._width + clearance):
                    self._kept = path, towards, grid.revision
                    return path
        revision, field = grid.revision, _Field(grid, start, goal, self._length, self._width, clearance)
        cells = field.search(start, goal)
        if cells is None:
            raise NoRoute(NO_PATH)
        end = [goal[:2]] if field.contains(goal) else []
        path = [start[:2], *cells[1:], *end]
        self._kept = path, goal[:2], revision
        return path


class _Field:
    """Lattice of poses over a map section: the gap beside the hull in each pose, and the search for a path."""

    def __init__(self, grid, start, goal, length, width, clearance):
        here, there = np.array(start[:2]), np.array(goal[:2])
        self._low = np.maximum(np.minimum(here, there) - MARGIN, here - REACH)
        high = np.minimum(np.maximum(here, there) + MARGIN, here + REACH)
        self._columns, self._rows = (ceil(n) + 1 for n in ((high - self._low) / SPACING).tolist())
        window = grid.window(tuple(self._low - 1.0), tuple(high + 1.0))
        occupied = window.states == OCCUPIED
        self._away = np.full(occupied.shape, inf)
        if occupied.any():
            self._away = distance_transform_edt(~occupied) * window.cell
        self._window = window
        self._x = self._low[0] + SPACING * np.arange(self._columns)[None, :] + np.zeros((self._rows, 1))
        self._y = self._low[1] + SPACING * np.arange(self._rows)[:, None] + np.zeros((1, self._columns))
        self._room = np.stack([self._gaps(k, length, width) for k in range(HEADINGS)], axis=-1) - clearance

    def _gaps(self, heading, length, width):
        """Gap between obstacles and the hull, approximated by discs, at every position [m], shape (rows, columns)."""
        count = max(1, ceil(length / width - 1e-9))
        part, yaw = length / (2 * count), heading * pi / 4.0
        radius, smallest = hypot(part, 0.5 * width), np.full(self._x.shape, inf)
        for k in range(count):
            ahead = (2 * k + 1) * part - 0.5 * length
            column = ((self._x + ahead * cos(yaw) - self._window.x) / self._window.cell).astype(np.intp)
            row = ((self._y + ahead * sin(yaw) - self._window.y) / self._window.cell).astype(np.intp)
            row, column = np.clip(row, 0, self._away.shape[0] - 1), np.clip(column, 0, self._away.shape[1] - 1)
            smallest = np.minimum(smallest, self._away[row, column] - radius)
        return smallest

    def contains(self, goal):
        """Whether a point is on the lattice."""
        column, row = (np.array(goal[:2]) - self._low) / SPACING
        return -0.5 <= column <= self._columns - 0.5 and -0.5 <= row <= self._rows - 0.5

    def search(self, start, goal):
        """Points of the cheapest path [m]; None if there is none."""
        graph, first = self._graph(start), self._node(start, round(start.yaw / (pi / 4.0)))
        distance, before = dijkstra(graph, indices=first, return_predecessors=True)
        ends = self._ends(goal)
        best = ends[distance[ends].argmin()]
        if distance[best] == inf:
            return None
        nodes = [best]
        while nodes[-1] != first:
            nodes.append(before[nodes[-1]])
        cells = dict.fromkeys(int(node) // HEADINGS for node in reversed(nodes))  # turns on the spot share one position
        return [(float(self._x.flat[c]), float(self._y.flat[c])) for c in cells]

    def _node(self, pose, heading):
        column, row = np.round((np.array(pose[:2]) - self._low) / SPACING).astype(int)
        row, column = np.clip(row, 0, self._rows - 1), np.clip(column, 0, self._columns - 1)
        return int((row * self._columns + column) * HEADINGS + heading % HEADINGS)

    def _ends(self, goal):
        """Target nodes: the goal at any heading, or the lattice's border nearest to it."""
        if self.contains(goal):
            return self._node(goal, 0) + np.arange(HEADINGS)
        away = np.hypot(self._x - goal.x, self._y - goal.y)
        rows, columns = np.nonzero(away <= away.min() + 2.0)
        return ((rows * self._columns + columns)[:, None] * HEADINGS + np.arange(HEADINGS)).ravel()

    def _graph(self, start):
        """Sparse graph of all motions where the hull fits: a step ahead, a bend to either side, a turn on the spot."""
        can = self._room > 0.0
        here = self._node(start, 0)
        can.reshape(-1)[here : here + HEADINGS] = True  # a robot that is too near to an obstacle may still drive off
        price = 1.0 / np.clip(self._room / EASE, SLOWEST, 1.0)
        sources, targets, costs = [], [], []
        for k, (i, j) in enumerate(STEPS):
            for turn in (-1, 0, 1):
                m = (k + turn) % HEADINGS
                di, dj = (i, j) if turn == 0 else (i + STEPS[m][0], j + STEPS[m][1])
                self._moves(can, price, (k, m), (di, dj), SPACING * hypot(di, dj), sources, targets, costs)
                if turn:
                    self._moves(can, price, (k, m), (0, 0), TURN, sources, targets, costs)
        size = self._rows * self._columns * HEADINGS
        return csr_array(
            (np.concatenate(costs), (np.concatenate(sources), np.concatenate(targets))), shape=(size, size)
        )

    def _moves(self, can, price, headings, step, length, sources, targets, costs):
        """Append one kind of motion, from every position where the hull fits before and after it, to the three lists.

        Args:
            can: Whether the hull fits in each pose, shape (rows, columns, headings).
            price: Cost of a metre in each pose, of the same shape.
            headings: Indices of the heading before and after the motion.
            step: Rows and columns by which the motion changes the position.
            length: Length of the motion [m].
            sources: Node indices before the motion.
            targets: Node indices after the motion.
            costs: Costs of the motions.
        """
        (k, m), (di, dj) = headings, step
        rows = slice(max(0, -di), self._rows - max(0, di)), slice(max(0, di), self._rows - max(0, -di))
        columns = slice(max(0, -dj), self._columns - max(0, dj)), slice(max(0, dj), self._columns - max(0, -dj))
        here, there = (rows[0], columns[0]), (rows[1], columns[1])
        allowed = can[here][..., k] & can[there][..., m]
        places = np.arange(self._rows * self._columns).reshape(self._rows, self._columns) * HEADINGS
        sources.append((places[here] + k)[allowed])
        targets.append((places[there] + m)[allowed])
        costs.append(length * 0.5 * (price[here][..., k] + price[there][..., m])[allowed])


def _clear(grid, path, room):
    """Whether a path found earlier still has about `room` [m] to the nearest obstacle everywhere."""
    points = np.vstack([np.linspace(a, b, max(2, ceil(dist(a, b) / 0.1))) for a, b in pairwise(path)])
    window = grid.window(tuple(points.min(axis=0) - 1.0), tuple(points.max(axis=0) + 1.0))
    obstacles = window.points()
    if not len(obstacles):
        return True
    gaps = np.hypot(obstacles[:, 0] - points[:, :1], obstacles[:, 1] - points[:, 1:]).min(axis=1)
    return bool((gaps > 0.9 * room).all())
