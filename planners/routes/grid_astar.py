"""Fastest path in the robot's own map, where near obstacles reduce the speed.

The path runs over the cells of `knowledge.world.occupancy`, from each cell to its eight neighbours; unobserved cells
count as free. The cost of a metre is the travel time at the speed that the distance to obstacles allows there. The path
therefore stays in the middle of gaps and avoids tight gaps if the detour is short. The path is found by A* (Hart,
Nilsson and Raphael, IEEE Transactions on Systems Science and Cybernetics 4, 1968), computed as SciPy's Dijkstra on
reduced costs. It is then smoothed as an elastic band (Quinlan and Khatib, ICRA 1993).

A path is kept while no new obstacle comes near it, and otherwise bent around the obstacle or replaced. A new path
begins with the part of the old one that the robot drives before it can turn off.
"""

from functools import cache
from math import cos, hypot, inf, isnan, sin, sqrt
from typing import NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt, label
from scipy.sparse.csgraph import dijkstra

from rocs_bt import Pose2
from rocs_bt.base.geometry import wrap_angle
from rocs_bt.control.elastic_band import STEP, DistanceField, headings, relaxed
from rocs_bt.control.footprint import Footprint
from rocs_bt.control.way_field import grid_graph
from rocs_bt.knowledge import OCCUPIED
from rocs_bt.plan import NO_PATH, MapRoutePlanner, NoRoute, Point

WINDOWS = (2.5, 8.0)  # [m] Margins of the map section around start and goal; the next one if there is no path.
REACH = 8.0  # [m] Maximum range of the map section around the robot; everything beyond counts as free.
BLOCK = 32  # Granularity of the map section [cells], so that few graph shapes occur.

EASE = 0.5  # [m] Clearance beyond which the speed is not reduced.
SLOWEST = 0.15  # Fraction of the full speed at zero clearance.
PINCH = 60.0  # Additional cost of a metre at zero clearance.
TIGHT = 100.0  # Cost of a metre (1 if free) where the grid cannot decide whether the hull fits.
BACK, NEAR = 3.0, 1.0  # Additional cost of a metre straight back, within NEAR [m] of the robot, for the turn.
FIRST = 0.8  # Cost bound of the first search, relative to a free straight line; the next one is 4 times larger,
WIDER = 3.0  # and above this one the last search has no bound.

MAX_CANDIDATES = 6  # Maximum number of candidate paths per search until the hull fits everywhere.
CLOSED_RADIUS = 0.15  # [m] Radius of the cells that are closed around a point where the hull does not fit.
AHEAD = 0.25  # [s] The distance driven in this time, plus the braking distance, follows the old path.
BESIDE = 0.2  # [m] Additional margin of the map section beside a path.
CHECK_INTERVAL = 0.15  # [s] Minimum interval between checks of a path against a changed map.
COST_CHANGE = 0.3  # Increase of a metre's cost that causes a path to be bent again.
COST_RATIO = 1.2  # A path is replaced when its cost exceeds the original cost by this factor,
CLEARANCE_TOLERANCE = 0.01  # [m] or when the clearance is violated by this distance.
ALIGNED = 0.2  # [m] Length constant (1/e) over which a robot aligns with the path;
TURN_FIRST = 0.6  # [rad] for larger angles it turns on the spot, as in FollowRoute.
MAX_PATH_DISTANCE = 0.3  # [m] Maximum distance between the robot and its path.
TURN = 6  # A path turns back if this many cells from its beginning it is behind the robot.
SHORT = 3.0  # [m] Remaining length at which a path that ends before the goal is replaced.


class GridAstar(MapRoutePlanner):
    """Plans in the robot's own map; requires the analyser LocalMap and the robot's length and width.

    `clearance` is kept from the hull at the headings along the path. Planners among known obstacles keep it at every
    heading.
    """

    def __init__(self, knowledge):
        super().__init__(knowledge)
        body = knowledge.graph.attributes(knowledge.agent)
        self._footprint = Footprint(body.get("length", 0.0), body.get("width", 0.0))
        self._brake = 0.8 * body.get("wheel_acceleration_limit", inf)
        self._planned = None
        self._checked = -inf
        self._closed = []

    def search(self, grid, start: Pose2, goal: Pose2, clearance: float) -> list[Point]:
        kept = self._planned if self._planned is not None and self._planned.serves(start, goal) else None
        now = self.knowledge.clock.now()
        if kept is not None and (
            kept.revision == self.revision_of(grid) or now - self._checked < CHECK_INTERVAL - 1e-6
        ):
            return kept.path
        self._checked = now
        self._planned = None
        if kept is not None:
            beside = self._section_beside(grid, kept.points[kept.nearest(start) :])
            self._planned = kept.bent(beside, self._footprint, start, self._ahead(), clearance)
            if self._planned is not None:
                return self._planned.path
        sections = cache(lambda around: self._field(grid, start, goal, around))
        for _ in range(2 if self._closed else 1):  # the second search without the cells that earlier searches closed
            for around in WINDOWS:
                self._planned = self._plan(sections(around), start, goal, clearance, kept)
                if self._planned is not None:
                    return self._planned.path
            self._closed.clear()
        raise NoRoute(NO_PATH)

    def _field(self, grid, start, goal, around):
        here, there = np.array(start[:2]), np.array(goal[:2])
        low = np.maximum(np.minimum(here, there) - around, here - REACH)
        high = np.minimum(np.maximum(here, there) + around, here + REACH)
        block = BLOCK * grid.cell
        size = np.ceil((high - low) / block) * block - 0.5 * grid.cell  # covers a whole number of blocks
        low = np.floor(low / grid.cell) * grid.cell + 0.25 * grid.cell
        return Field.of(grid.window(tuple(low), tuple(low + size), moving=self.moving), self._footprint.inner)

    def _section_beside(self, grid, points):
        """Map section beside a path, large enough for its costs and clearances."""
        reach = self._footprint.inner + EASE + BESIDE
        low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
        window = grid.window(tuple(low), tuple(high), moving=self.moving)
        return Field.of(window, self._footprint.inner)

    def _plan(self, field, start, goal, clearance, kept):
        """Search a path on which the hull fits everywhere; None if there is none."""
        committed = self._committed(kept, field, start)
        cost = field.cost.copy()
        _allow_departure(field, cost, committed[-1])
        _add_turn_cost(field, cost, start)
        for point in self._closed:
            field.close(cost, point)
        for _ in range(MAX_CANDIDATES):
            cells = _search(field, cost, committed[-1], goal)
            if cells is None:
                return None
            if _turns_back(
                committed, cells
            ):  # the robot stops before it turns round, so the path begins at its position
                committed = np.array([start[:2]])
                _allow_departure(field, cost, committed[-1])
                continue
            planned = _smoothed(field, self._footprint, committed, cells, goal)
            point = _too_tight(field, self._footprint, planned.points, start, clearance)
            if point is None:
                return planned
            field.close(cost, point)
            self._closed.append(point)
        return None

    def _ahead(self):
        """Distance that the robot drives before it can turn off [m]."""
        speed = self.knowledge.robot.speed()
        speed = 0.0 if isnan(speed) else max(speed, 0.0)
        return speed * AHEAD + speed * speed / (2.0 * self._brake)

    def _committed(self, kept, field, start):
        """Points that the robot drives before it can turn off to a new path, from its position on [m], shape (k, 2)."""
        ahead, here = self._ahead(), np.array(start[:2])
        if kept is not None:
            points = kept.ahead(start, ahead)
        else:
            steps = np.arange(STEP, ahead, STEP)[:, None]
            points = np.vstack([here, here + steps * (cos(start.yaw), sin(start.yaw))])
        free = field.around.sample(field.around.distance, points) > field.inner
        return points[: max(1, int(np.argmin(free)) if not free.all() else len(points))]


class Field(NamedTuple):
    """Costs and obstacles of a map section for the search."""

    around: DistanceField
    cost: np.ndarray  # (rows, columns) cost of a metre, at least 1; inf where the hull does not fit
    inner: float  # radius of the hull's inner circle [m]
    revision: int

    @classmethod
    def of(cls, window, inner):
        occupied, far = window.states == OCCUPIED, inner + EASE
        away = np.full(occupied.shape, far)
        if occupied.any():
            cells, nearest = distance_transform_edt(~occupied, return_indices=True)
            near = cells < far / window.cell + 1.0
            row, column = nearest[:, near]
            here = np.argwhere(near)[:, ::-1] + 0.5
            away[near] = np.hypot(*((window.x, window.y) + here * window.cell - window.echoes[row, column]).T)
            away = np.minimum(away, far)
        share = (away - inner) / EASE
        cost = 1.0 / np.clip(share, SLOWEST, 1.0) + PINCH * np.clip(1.0 - share / SLOWEST, 0.0, 1.0)
        cost[away < inner] = TIGHT
        cost[away < inner - 0.6 * window.cell] = inf
        around = DistanceField(window.x, window.y, window.cell, away, window.points())
        return cls(around, cost, inner, window.revision)

    def close(self, cost, point):
        """Set the costs of the cells around a point [m] to infinity, where the hull does not fit."""
        away = self.around.centres() - point
        cost[(away * away).sum(axis=-1) < CLOSED_RADIUS * CLOSED_RADIUS] = inf

    def costs(self, points):
        """Cost of a metre at points (k, 2) [m], shape (k,); at most TIGHT."""
        return self.around.sample(np.minimum(self.cost, TIGHT), points)


class PlannedPath(NamedTuple):
    """Planned path, with the costs that tell later whether it must be changed."""

    points: np.ndarray  # (k, 2) [m]
    path: list[Point]  # the same points, as returned to missions
    costs: np.ndarray  # (k,) cost of a metre when the path was last bent
    found: np.ndarray  # (k,) cost of a metre when the path was found
    goal: Point
    complete: bool  # whether it ends at the goal
    revision: int  # of the map at the last check

    def nearest(self, start):
        return int(np.hypot(*(self.points - start[:2]).T).argmin())

    def serves(self, start, goal):
        """Whether the path leads to the goal, is long enough, and the robot is on it."""
        nearest = self.nearest(start)
        off = hypot(*(self.points[nearest] - start[:2]))
        left = STEP * (len(self.points) - nearest)
        return self.goal == goal[:2] and off < MAX_PATH_DISTANCE and (self.complete or left > SHORT)

    def bent(self, field, footprint, start, ahead, clearance):
        """Path in a changed map: unchanged, or bent around new obstacles; None if it must be replaced.

        The part that is driven within `ahead` [m] is not changed.
        """
        first = max(self.nearest(start) - 1, 0)
        planned, now = self, field.costs(self.points[first:])
        if (now > self.costs[first:] + COST_CHANGE).any():
            points = relaxed(field.around, footprint, self.points[first:], 2 + int(ahead / STEP))
            now, found = field.costs(points), self.found[first:]
            planned = self._replace(points=points, path=[tuple(p) for p in points.tolist()], costs=now, found=found)
            first = 0
        costlier = now.sum() > COST_RATIO * planned.found[first:].sum() + SHORT / STEP
        if (
            costlier
            or _too_tight(field, footprint, planned.points[first:], start, clearance - CLEARANCE_TOLERANCE) is not None
        ):
            return None
        return planned._replace(revision=field.revision)

    def ahead(self, start, distance):
        """Next part of the path [m], shape (k, 2); only the robot's position if it is nearly stationary."""
        nearest, count = self.nearest(start), int(distance / STEP)
        return self.points[max(nearest - 1, 0) : nearest + 1 + count] if count else np.array([start[:2]])


def _search(field, cost, start, goal):
    """Find the cheapest path over cells; if the goal is outside the map section, to the best cell of its border.

    Returns:
        Cell centres from start to goal [m], shape (k, 2); None without a path.
    """
    rows, columns = cost.shape
    here, there = field.around.cell(start), field.around.cell(goal)
    row, column = np.indices(cost.shape)
    aim = (
        (goal[1] - field.around.y) / field.around.cell_size - 0.5,
        (goal[0] - field.around.x) / field.around.cell_size - 0.5,
    )
    up, aside = np.abs(row - aim[0]), np.abs(column - aim[1])
    guess = np.maximum(up, aside) + (sqrt(2.0) - 1.0) * np.minimum(up, aside)
    ends = np.array([there[0] * columns + there[1]]) if there is not None else _edge(rows, columns, aim)
    parts, _ = label(np.isfinite(cost), structure=np.ones((3, 3)))  # much faster than a search that finds no path
    if not parts[here] or not (parts.reshape(-1)[ends] == parts[here]).any():  # part 0: the closed cells
        return None
    graph, first, limit = grid_graph(cost, guess), here[0] * columns + here[1], FIRST * guess[here]
    while True:
        distance, before = dijkstra(graph, indices=first, return_predecessors=True, limit=limit)
        best = ends[distance[ends].argmin()]
        if distance[best] < inf:
            break
        limit = inf if limit > WIDER * guess[here] else 4.0 * limit
    nodes = [best]
    while nodes[-1] != first:
        nodes.append(before[nodes[-1]])
    return field.around.centres().reshape(-1, 2)[nodes[::-1]]


def _allow_departure(field, cost, point):
    """Change the costs so that a robot too near to an obstacle can drive off, at a high cost."""
    around, here = int(0.5 / field.around.cell_size), field.around.cell(point)
    if cost[here] == inf:
        part = tuple(slice(max(at - around, 0), at + around + 1) for at in here)
        cost[part] = np.where(
            np.isinf(cost[part]) & (field.around.distance[part] > field.around.cell_size), TIGHT, cost[part]
        )
        cost[here] = TIGHT


def _add_turn_cost(field, cost, start):
    """Add the cost of the initial turn to the cells near the robot."""
    reach = int(NEAR / field.around.cell_size)
    row, column = field.around.cell(start)
    part = slice(max(row - reach, 0), row + reach + 1), slice(max(column - reach, 0), column + reach + 1)
    rows, columns = np.mgrid[part]
    y, x = (rows - row) * field.around.cell_size, (columns - column) * field.around.cell_size
    away = np.hypot(x, y)
    back = 0.5 - 0.5 * (x * cos(start.yaw) + y * sin(start.yaw)) / np.maximum(away, field.around.cell_size)
    cost[part][:] += np.where(away < NEAR, BACK * back, 0.0)[: cost[part].shape[0], : cost[part].shape[1]]


def _edge(rows, columns, aim):
    """Indices of the cells at those borders of the map section beyond which the goal is."""
    own, (row, column) = np.arange(rows * columns).reshape(rows, columns), aim
    beyond = ((own[0], row < 0.0), (own[-1], row >= rows), (own[:, 0], column < 0.0), (own[:, -1], column >= columns))
    return np.concatenate([edge for edge, is_beyond in beyond if is_beyond])


def _turns_back(committed, cells):
    """Whether a new path leads back over the committed part, which the robot drives before the path begins."""
    if len(committed) < 2:
        return False
    first, ahead = committed[-1] - committed[-2], cells[min(TURN, len(cells) - 1)] - cells[0]
    return float(first @ ahead) < -0.3 * hypot(*first) * hypot(*ahead)


def _smoothed(field, footprint, committed, cells, goal):
    """Smooth a path over cells, except the `committed` points, which the robot drives before it can turn off."""
    complete = field.around.cell(goal) is not None
    rough = np.vstack([committed, cells[1:], *([np.array([goal[:2]])] if complete else [])])
    points = relaxed(field.around, footprint, _resampled(rough, len(committed)), len(committed))
    costs = field.costs(points)
    return PlannedPath(points, [tuple(p) for p in points.tolist()], costs, costs, goal[:2], complete, field.revision)


def _too_tight(field, footprint, points, start, clearance):
    """Point of a path where the hull violates the clearance most [m]; None if the hull fits everywhere.

    Near the robot's present position a smaller gap is allowed, if the path does not decrease it and there is no
    contact.
    """
    if len(points) < 2:
        return None
    near = np.flatnonzero(field.around.sample(field.around.distance, points) < footprint.outer + clearance)
    if len(near) == 0:
        return None
    yaws = headings(points)
    off = wrap_angle(start.yaw - float(yaws[0]))
    if abs(off) < TURN_FIRST:  # the robot aligns with the path while it drives
        yaws += off * np.exp(-np.hypot(*(points - start[:2]).T) / ALIGNED)
    poses = np.column_stack([points, yaws])[near]
    low, high = points[near].min(axis=0) - 0.5, points[near].max(axis=0) + 0.5
    obstacles = field.around.points[((field.around.points > low) & (field.around.points < high)).all(axis=1)]
    now, *gaps = footprint.clearance(np.vstack([start, poses]), obstacles)
    least = min(clearance, max(now - CLEARANCE_TOLERANCE, min(now, 0.0)))
    here = np.hypot(*(points[near] - start[:2]).T) < footprint.outer
    lack = np.where(here, least, clearance) - gaps
    return None if lack.max() <= 0.0 else tuple(points[near[lack.argmax()]])


def _resampled(points, kept):
    """Points of a path resampled with even spacing; the first `kept` points are unchanged."""
    head, tail = points[:kept], points[kept - 1 :]
    stations = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(tail, axis=0).T))])
    at = np.linspace(0.0, stations[-1], max(2, round(stations[-1] / STEP) + 1))
    return np.vstack([head, np.column_stack([np.interp(at, stations, tail[:, i]) for i in (0, 1)])[1:]])
