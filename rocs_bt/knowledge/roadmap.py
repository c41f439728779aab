"""Roadmap: the places that are known and the roads between them, as a graph that routes are searched on.

The nodes are places and goals; the edges are the relation `connects`, one for each direction that can be driven. A road
counts while it is open, while no door that lies between its ends is known to be closed, and where it is wide enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise, permutations
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import KnowledgeError
from ..geometry import Pose2

if TYPE_CHECKING:
    from .knowledge import Knowledge
    from .occupancy import Window

Point = tuple[float, float]
"""x and y in the world frame [m]."""

Search = Callable[[Any, str, str, Callable[[str, str], float]], list[str]]
"""Finds the cheapest chain of nodes: of a networkx DiGraph whose edges have a `weight`, from one node to another, with
a lower bound of what is left between two nodes. Raises networkx.NetworkXNoPath."""

SAME_POSITION = 1e-6  # [m] Who is so near to a place is there.
_START, _END = "\0start", "\0end"  # which no place is called


class Route(NamedTuple):
    """A way over a roadmap.

    Attributes:
        points: Its corners, from the start to the goal, in the world frame [m].
        places: The names of the places on it.
        cost: Metres, weighed by how unwelcome each road is.
    """

    points: list[Point]
    places: list[str]
    cost: float


class Roadmap:
    """What can be driven now, as it stands in the graph at this moment.

    Args:
        knowledge: All that a robot knows.
        width: Roads that are known to be narrower are left out [m].

    Attributes:
        graph: A networkx DiGraph of the roads that count; each edge's `weight` is its length [m] times its cost.
        closed: What is left out, for people: `hall-shed (too narrow)`, `hall-store (door_2 is closed)`.
    """

    def __init__(self, knowledge: Knowledge, width: float = 0.0) -> None:
        import networkx

        self.graph = networkx.DiGraph()
        self._at: dict[str, Point] = {}
        self._roads: list[tuple[str, str]] = []  # those that are closed too: somebody may stand on one
        self.closed: list[str] = []
        with knowledge.graph.locked():
            shut = _shut(knowledge)
            for source, target, road in _roads(knowledge):
                if why := _in_the_way(road, width, shut.get((source, target))):
                    self.closed.append(f"{source}-{target} ({why})")
                self._join(knowledge, source, target, road, is_open=not why)
        slopes = [d["weight"] / away for a, b, d in self.graph.edges(data=True) if (away := self._away(a, b)) > 0.0]
        self._least = min(slopes, default=0.0)

    def route(self, start: Point, goal: Point, search: Search) -> Route | None:
        """The cheapest way over the roads; None where there is none.

        The way onto the roads and from them to the goal is straight: to the ends of the road that is nearest, or to the
        place that one stands at. Who stands on a road that is closed leaves it by its nearer end; nobody is led onto
        one.

        Args:
            start: In the world frame [m].
            goal: In the world frame [m].
            search: How to search.

        Raises:
            KnowledgeError: No road can be driven at all.
        """
        import networkx

        if not self.graph.edges:
            closed = f" Closed: {', '.join(self.closed)}." if self.closed else ""
            raise KnowledgeError(f"no road can be driven; relate places with 'connects', as [[road]] does.{closed}")
        graph, self._at[_START], self._at[_END] = self.graph.copy(), start, goal
        graph.add_nodes_from((_START, _END))
        graph.add_weighted_edges_from((_START, n, self._away(_START, n)) for n in self._entries(start))
        graph.add_weighted_edges_from((n, _END, self._away(n, _END)) for n in self._exits(goal))
        if self._straight_on(start, goal):  # on one road nobody drives to its end and back
            graph.add_edge(_START, _END, weight=math.dist(start, goal))
        least = min(self._least, 1.0)
        try:
            chain = search(graph, _START, _END, lambda a, b: least * self._away(a, b))
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
            length = max(road.get("length", 0.0), self._away(source, target))
            self.graph.add_edge(source, target, weight=length * road.get("cost", 1.0))

    def _away(self, a: str, b: str) -> float:
        return math.dist(self._at[a], self._at[b])

    def _nearest(self, point: Point) -> tuple[str, ...]:
        """The place that is at a point; else the ends of the road that is nearest, of equal ones an open one."""

        def order(road: tuple[str, str]) -> tuple[float, bool, bool, tuple[str, str]]:
            away = segment_distance(point, self._at[road[0]], self._at[road[1]])
            # A road that passes over a place without a junction is as near as those that end there.
            return round(away, 9), not here(road), not self.graph.has_edge(*road), road

        def here(road: tuple[str, str]) -> list[str]:
            return [n for n in road if math.dist(point, self._at[n]) < SAME_POSITION]

        ends = min(self._roads, key=order)
        return tuple(here(ends)[:1]) or ends

    def _entries(self, start: Point) -> list[str]:
        """The places that one can drive to first; of a road that is closed the nearer end."""
        ends = self._nearest(start)
        ahead = [b for a, b in permutations(ends, 2) if self.graph.has_edge(a, b)]
        return ahead or [min(ends, key=lambda n: math.dist(start, self._at[n]))]

    def _exits(self, goal: Point) -> list[str]:
        """The places from which one can drive to the goal."""
        ends = self._nearest(goal)
        return [a for a, b in permutations(ends, 2) if self.graph.has_edge(a, b)] or list(ends)[: len(ends) == 1]

    def _straight_on(self, start: Point, goal: Point) -> bool:
        ends = self._nearest(start)
        if len(ends) == 1 or set(ends) != set(self._nearest(goal)):
            return False
        a, b = ends if math.dist(start, self._at[ends[0]]) <= math.dist(goal, self._at[ends[0]]) else ends[::-1]
        return bool(self.graph.has_edge(a, b))


def segment_distance(point: Point, a: Point, b: Point) -> float:
    """How far a point is from a line between two others [m]."""
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


def _shut(knowledge: Knowledge) -> dict[tuple[str, str], str]:
    """The pairs of places between which a door is known to be closed, each with the door."""
    graph = knowledge.graph
    closed = [door for door in graph.nodes("door") if graph.get(door, "open") is False]
    return {pair: door for door in closed for pair in permutations(graph.related(door, "leads_to"), 2)}


def _in_the_way(road: dict[str, Any], width: float, door: str | None) -> str:
    """Why a road cannot be driven; empty where it can."""
    if not road.get("open", True):
        return "closed"
    if door is not None:
        return f"{door} is closed"
    return "too narrow" if road.get("width", math.inf) < width else ""


def add_lattice_roads(
    knowledge: Knowledge, window: Window, *, spacing: float, clearance: float, prefix: str = "at"
) -> list[str]:
    """Make places and roads of the free space of a map, as a lattice; gives the names of the places.

    Places stand on a square lattice wherever the map is free and far enough from what is occupied; each is connected,
    both ways, with those of its eight neighbours to which the straight way is free as well.

    Args:
        knowledge: Whose graph they are put into.
        window: The map.
        spacing: Of the lattice [m]; no less than a cell.
        clearance: What to keep from occupied and unknown cells [m].
        prefix: The places are named PREFIX_COLUMN_ROW.

    Raises:
        KnowledgeError: The spacing is less than a cell, or a name is taken.
    """
    import numpy as np
    from scipy.ndimage import distance_transform_edt

    from .occupancy import FREE

    if spacing < window.cell:
        raise KnowledgeError(f"roads {spacing} m apart cannot be drawn on cells of {window.cell} m; take more.")
    away = distance_transform_edt(np.pad(window.states == FREE, 1))[1:-1, 1:-1] * window.cell
    clear = away > clearance
    every = spacing / window.cell
    rows, columns = (np.floor((np.arange(int(n / every)) + 0.5) * every).astype(int) for n in clear.shape)
    at = {(i, j): (int(r), int(c)) for i, r in enumerate(rows) for j, c in enumerate(columns) if clear[r, c]}
    names = {key: f"{prefix}_{key[1]}_{key[0]}" for key in at}
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
    """Whether all cells between two are clear."""
    steps = max(abs(b[0] - a[0]), abs(b[1] - a[1])) * 2
    return all(
        clear[round(a[0] + (b[0] - a[0]) * k / steps), round(a[1] + (b[1] - a[1]) * k / steps)]
        for k in range(steps + 1)
    )
