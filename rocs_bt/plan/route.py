"""Route planners: ways from here to there, around what is known to stand there."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from ..errors import KnowledgeError
from ..geometry import Pose2
from ..knowledge import Knowledge, Roadmap, Route, segment_distance

Point = tuple[float, float]
"""x and y in the world frame [m]."""

OFF = 0.5
"""Farther from its way than this a robot is given another [m]."""


class NoRoute(Exception):
    """There is no way; the message tells what is in it, as a planner raises it."""


class RoutePlanner(ABC):
    """Finds ways for one robot. A file in `planners/routes` holds one such class, and missions name the file.

        class Straight(RoutePlanner):
            def route(self, start, goal, clearance):
                return [start[:2], goal[:2]]

    Args:
        knowledge: All that the robot knows.
    """

    def __init__(self, knowledge: Knowledge) -> None:
        self.knowledge = knowledge

    @abstractmethod
    def route(self, start: Pose2, goal: Pose2, clearance: float) -> Sequence[Point]:
        """The corners of a way, the first of them the start's position and the last the goal's. Must not block.

        Args:
            start: In the world frame.
            goal: In the world frame.
            clearance: What to keep at least between the robot's hull, however it turns, and what is known [m].

        Raises:
            NoRoute: There is none.
        """


class RoadRoutePlanner(RoutePlanner):
    """Finds ways over the roads that are known and open: the relation `connects` between places, and the doors on them.

    class Fewest(RoadRoutePlanner):
        def search(self, graph, start, goal, least):
            return networkx.shortest_path(graph, start, goal)
    """

    @abstractmethod
    def search(self, graph: Any, start: str, goal: str, least: Callable[[str, str], float]) -> list[str]:
        """The nodes of the cheapest way.

        Args:
            graph: A networkx DiGraph; each edge's `weight` is what it costs.
            start: The node to begin at.
            goal: The node to end at.
            least: What the way between two nodes costs at least.

        Raises:
            networkx.NetworkXNoPath: There is none.
        """

    def __init__(self, knowledge: Knowledge) -> None:
        super().__init__(knowledge)
        self._kept: tuple[Any, Point, Route] | None = None  # the roads, the goal, the way

    def route(self, start: Pose2, goal: Pose2, clearance: float) -> list[Point]:
        """The corners of a way over the roads that are as wide as the robot and the clearance on both sides [m].

        The way is kept, as the same list, while the roads, their costs and the goal are as they were and the robot is
        on it; so a mission may ask again and again, and hears of a new way when a road closes, or opens again.

        Raises:
            NoRoute: No road can be driven, or none leads there; tells which are closed.
        """
        width = self.knowledge.graph.attributes(self.knowledge.agent).get("width", 0.0)
        roads = Roadmap(self.knowledge, width + 2.0 * clearance)
        if self._kept is not None:
            known, towards, kept = self._kept
            if known == roads.graph.adj and towards == goal[:2] and off_way(start[:2], kept.points) <= OFF:
                return kept.points
        try:
            way = roads.route(start[:2], goal[:2], self.search)
        except KnowledgeError as error:
            raise NoRoute(str(error)) from error
        if way is None:
            closed = f"; closed: {', '.join(roads.closed)}" if roads.closed else ""
            raise NoRoute(f"no road that is open leads there{closed}")
        self._kept = roads.graph.adj, goal[:2], way
        return way.points

    @property
    def way(self) -> Route | None:
        """The way that `route` has returned last, with its places and its cost; None before the first one."""
        return None if self._kept is None else self._kept[2]


def off_way(point: Point, way: Sequence[Point]) -> float:
    """How far a point is from a way's nearest leg [m]."""
    return min(segment_distance(point, a, b) for a, b in pairwise(way)) if len(way) > 1 else math.dist(point, way[0])
