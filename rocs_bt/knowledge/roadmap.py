"""Roadmap: known places and the roads between them, as a graph for route search.

The roadmap's nodes are places and goals. Its edges are those of the relation `connects`, one for each direction that
can be driven. A road is usable while it is open, wide enough, and no door between its ends is known to be closed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise, permutations
from typing import TYPE_CHECKING, Any, NamedTuple

from ..base.errors import KnowledgeError
from ..base.geometry import Pose2

if TYPE_CHECKING:
    from .knowledge import Knowledge
    from .occupancy import Window

Point = tuple[float, float]
"""x and y in the world frame [m]."""

Search = Callable[[Any, str, str, Callable[[str, str], float]], list[str]]
"""Shortest-path search: (networkx DiGraph with `weight` on its edges, start node, goal node, heuristic) -> nodes of
the path. The heuristic is a lower bound of the cost between two nodes. It raises networkx.NetworkXNoPath."""

SAME_POSITION = 1e-6  # [m] maximum distance at which a point counts as being at a place
_START, _END = "\0start", "\0end"  # no place can have these names


class Route(NamedTuple):
    """Route over a roadmap.

    Attributes:
        points: Corners from the start to the goal, world frame [m].
        places: Names of the places along the route.
        cost: Sum over all roads of length [m] times cost factor.
    """

    points: list[Point]
    places: list[str]
    cost: float


class Roadmap:
    """Snapshot of the roads that can be driven now.

    Args:
        knowledge: Knowledge with the places and roads.
        width: Minimum road width; roads known to be narrower are left out [m].

    Attributes:
        graph: networkx DiGraph of the usable roads; each edge's `weight` is its length [m] times its cost.
        closed: Descriptions of the unusable roads: `hall-shed (too narrow)`, `hall-store (door_2 is closed)`.
    """

    def __init__(self, knowledge: Knowledge, width: float = 0.0) -> None:
        import networkx

        self.graph = networkx.DiGraph()
        self._at: dict[str, Point] = {}
        self._roads: list[tuple[str, str]] = []  # closed roads too: a robot may be on one
        self.closed: list[str] = []
        with knowledge.graph.locked():
            doors = _closed_doors(knowledge)
            for source, target, road in _roads(knowledge):
                if why := _closed_reason(road, width, doors.get((source, target))):
                    self.closed.append(f"{source}-{target} ({why})")
                self._join(knowledge, source, target, road, is_open=not why)
        slopes = [d["weight"] / away for a, b, d in self.graph.edges(data=True) if (away := self._distance(a, b)) > 0.0]
        self._min_slope = min(slopes, default=0.0)

    def route(self, start: Point, goal: Point, search: Search) -> Route | None:
        """The cheapest route over the roads; None if there is none.

        The route enters and leaves the road network on a straight line: to the ends of the nearest road, or to the
        place at the robot's position. From a closed road it leaves by the nearer end; it never enters a closed road.

        Args:
            start: Start position, world frame [m].
            goal: Goal position, world frame [m].
            search: Search function.

        Raises:
            KnowledgeError: No road can be driven at all.
        """
        import networkx

        if not self.graph.edges:
            closed = f" Closed: {', '.join(self.closed)}." if self.closed else ""
            raise KnowledgeError(f"no road can be driven; relate places with 'connects', as [[road]] does.{closed}")
        graph, self._at[_START], self._at[_END] = self.graph.copy(), start, goal
        graph.add_nodes_from((_START, _END))
        graph.add_weighted_edges_from((_START, n, self._distance(_START, n)) for n in self._entries(start))
        graph.add_weighted_edges_from((n, _END, self._distance(n, _END)) for n in self._exits(goal))
        if self._straight_on(start, goal):  # start and goal on one road: drive directly, not by way of its end
            graph.add_edge(_START, _END, weight=math.dist(start, goal))
        slope = min(self._min_slope, 1.0)
        try:
            chain = search(graph, _START, _END, lambda a, b: slope * self._distance(a, b))
        except networkx.NetworkXNoPath:
            return None
        cost = sum(graph.edges[edge]["weight"] for edge in pairwise(chain))
        points = [start, *(self._at[n] for n in chain[1:-1]), goal]
        return Route([p for i, p in enumerate(points) if i == 0 or p != points[i - 1]], chain[1:-1], cost)

    def _join(self, knowledge: Knowledge, source: str, target: str, road: dict[str, Any], *, is_open: bool) -> None:
        for node in (source, target):
            pose: Pose2 = knowledge.graph.get(node, "pose")
            self._at[node] = pose.x, pose.y
        self._roads.append((source, target))
        if is_open:
            length = max(road.get("length", 0.0), self._distance(source, target))
            self.graph.add_edge(source, target, weight=length * road.get("cost", 1.0))

    def _distance(self, a: str, b: str) -> float:
        return math.dist(self._at[a], self._at[b])

    def _nearest(self, point: Point) -> tuple[str, ...]:
        """The place at a point, or else both ends of the nearest road; of equally near roads, an open one."""

        def order(road: tuple[str, str]) -> tuple[float, bool, bool, tuple[str, str]]:
            away = segment_distance(point, self._at[road[0]], self._at[road[1]])
            # A road that crosses a place without a junction is as near as the roads that end there.
            return round(away, 9), not here(road), not self.graph.has_edge(*road), road

        def here(road: tuple[str, str]) -> list[str]:
            return [n for n in road if math.dist(point, self._at[n]) < SAME_POSITION]

        ends = min(self._roads, key=order)
        return tuple(here(ends)[:1]) or ends

    def _entries(self, start: Point) -> list[str]:
        """Places to which a route can drive first from its start; on a closed road, the nearer end of the road."""
        ends = self._nearest(start)
        ahead = [b for a, b in permutations(ends, 2) if self.graph.has_edge(a, b)]
        return ahead or [min(ends, key=lambda n: math.dist(start, self._at[n]))]

    def _exits(self, goal: Point) -> list[str]:
        """Places from which a route can drive straight to its goal."""
        ends = self._nearest(goal)
        return [a for a, b in permutations(ends, 2) if self.graph.has_edge(a, b)] or list(ends)[: len(ends) == 1]

    def _straight_on(self, start: Point, goal: Point) -> bool:
        ends = self._nearest(start)
        if len(ends) == 1 or set(ends) != set(self._nearest(goal)):
            return False
        a, b = ends if math.dist(start, self._at[ends[0]]) <= math.dist(goal, self._at[ends[0]]) else ends[::-1]
        return bool(self.graph.has_edge(a, b))


def segment_distance(point: Point, a: Point, b: Point) -> float:
    """Distance from a point to a line segment [m]."""
    along, length = (b[0] - a[0], b[1] - a[1]), math.dist(a, b)
    if length == 0.0:
        return math.dist(point, a)
    share = ((point[0] - a[0]) * along[0] + (point[1] - a[1]) * along[1]) / length**2
    share = min(max(share, 0.0), 1.0)
    return math.dist(point, (a[0] + share * along[0], a[1] + share * along[1]))


def _roads(knowledge: Knowledge) -> Iterator[tuple[str, str, dict[str, Any]]]:
    graph = knowledge.graph
    for source, relation, target in graph.edges("connects"):
        yield source, target, graph.edge(source, relation, target) or {}


def _closed_doors(knowledge: Knowledge) -> dict[tuple[str, str], str]:
    """Doors that are known to be closed, by the ordered pair of places that each connects."""
    graph = knowledge.graph
    closed = [door for door in graph.nodes("door") if graph.get(door, "open") is False]
    return {pair: door for door in closed for pair in permutations(graph.related(door, "leads_to"), 2)}


def _closed_reason(road: dict[str, Any], width: float, door: str | None) -> str:
    """Reason why a road cannot be driven; empty if it can."""
    if not road.get("open", True):
        return "closed"
    if door is not None:
        return f"{door} is closed"
    return "too narrow" if road.get("width", math.inf) < width else ""


def add_lattice_roads(knowledge: Knowledge, window: Window, *, spacing: float, clearance: float) -> list[str]:
    """Add a square lattice of places and roads over the free space of a map.

    A place is added wherever the map is free and far enough from occupied and unknown cells. Each place is connected,
    in both directions, with those of its eight neighbours to which the straight line is free as well.

    Args:
        knowledge: Knowledge that receives the places and roads in its graph.
        window: Map.
        spacing: Lattice spacing [m]; at least one cell.
        clearance: Minimum distance to occupied and unknown cells [m].

    Returns:
        Names of the places, `at_COLUMN_ROW`.

    Raises:
        KnowledgeError: The spacing is less than a cell, or a name is taken.
    """
    import numpy as np
    from scipy.ndimage import distance_transform_edt

    from .occupancy import FREE

    if spacing < window.cell:
        raise KnowledgeError(f"the lattice spacing {spacing} m is less than a cell of {window.cell} m; increase it.")
    away = distance_transform_edt(np.pad(window.states == FREE, 1))[1:-1, 1:-1] * window.cell
    clear = away > clearance
    every = spacing / window.cell
    rows, columns = (np.floor((np.arange(int(n / every)) + 0.5) * every).astype(int) for n in clear.shape)
    at = {(i, j): (int(r), int(c)) for i, r in enumerate(rows) for j, c in enumerate(columns) if clear[r, c]}
    names = {key: f"at_{key[1]}_{key[0]}" for key in at}
    with knowledge.graph.locked():
        for key, (r, c) in at.items():
            pose = Pose2(window.x + (c + 0.5) * window.cell, window.y + (r + 0.5) * window.cell, 0.0)
            knowledge.world.place(names[key], pose)
        for (i, j), cell in at.items():
            for other in ((i, j + 1), (i + 1, j - 1), (i + 1, j), (i + 1, j + 1)):
                if other in at and _free(clear, cell, at[other]):
                    length = window.cell * math.dist(cell, at[other])
                    knowledge.graph.relate(names[i, j], "connects", names[other], length=length)
                    knowledge.graph.relate(names[other], "connects", names[i, j], length=length)
    return list(names.values())


def _free(clear: Any, a: tuple[int, int], b: tuple[int, int]) -> bool:
    """Whether all cells between two cells are clear."""
    steps = max(abs(b[0] - a[0]), abs(b[1] - a[1])) * 2
    return all(
        clear[round(a[0] + (b[0] - a[0]) * k / steps), round(a[1] + (b[1] - a[1]) * k / steps)]
        for k in range(steps + 1)
    )
