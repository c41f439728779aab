"""Interfaces of route planners, which plan paths to a goal around known obstacles."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from ..base.errors import KnowledgeError
from ..base.geometry import Pose2, wrap_angle
from ..knowledge import Knowledge, OccupancyGrid, Roadmap, Route, segment_distance

Point = tuple[float, float]
"""x and y in the world frame [m]."""

MAX_PATH_DISTANCE = 0.5
"""Distance between a robot and its path from which on a new path is planned [m]."""


NO_PATH = "the map contains no path to the goal"
"""Reason of a search that found no path in the robot's own map."""

SAME_YAW = 0.3
"""Turn of the robot from which on a search that failed is repeated [rad]."""


class NoRoute(Exception):
    """Raised by a route planner if there is no path to the goal; the message is the reason."""


class RoutePlanner(ABC):
    """Base class of planners of paths for one robot.

    A file in `planners/routes` contains one such class; missions refer to it by the name of the file.

        class Straight(RoutePlanner):
            def route(self, start, goal, clearance):
                return [start[:2], goal[:2]]
    """

    def __init__(self, knowledge: Knowledge) -> None:
        self.knowledge = knowledge

    @abstractmethod
    def route(self, start: Pose2, goal: Pose2, clearance: float) -> Sequence[Point]:
        """Plan a path; returns its corners from the start to the goal, world frame [m]. It must not block.

        Args:
            start: Start pose, world frame.
            goal: Goal pose, world frame.
            clearance: Minimum gap between the robot's hull at any heading and known obstacles [m].

        Raises:
            NoRoute: There is no path.
        """


class MapRoutePlanner(RoutePlanner):
    """Base class of planners of paths through the robot's own map, which the analyser LocalMap builds.

    A search that failed is not repeated while the map, the goal, the clearance and the robot's pose are the same.

    Attributes:
        moving: Whether paths lead around the echoes of what moves; not needed if the follower avoids them itself.
    """

    def __init__(self, knowledge: Knowledge) -> None:
        super().__init__(knowledge)
        self.moving = True
        self._failed: tuple[int, Pose2, Pose2, float, NoRoute] | None = None

    @abstractmethod
    def search(self, grid: OccupancyGrid, start: Pose2, goal: Pose2, clearance: float) -> Sequence[Point]:
        """Search for a path in a map; arguments and result as those of `route`.

        Raises:
            NoRoute: There is no path.
        """

    def route(self, start: Pose2, goal: Pose2, clearance: float) -> Sequence[Point]:
        """Plan a path in the robot's map.

        Raises:
            NoRoute: There is no path, or the robot builds no map.
        """
        grid = self.knowledge.world.occupancy
        if grid is None:
            raise NoRoute("the robot builds no map; add the analyser LocalMap")
        present = self.revision_of(grid)
        if self._failed is not None:
            revision, here, there, gap, reason = self._failed
            stays = start.distance(here) < grid.cell and abs(wrap_angle(start.yaw - here.yaw)) < SAME_YAW
            if revision == present and there == goal and gap == clearance and stays:
                raise NoRoute(*reason.args)
            self._failed = None
        try:
            return self.search(grid, start, goal, clearance)
        except NoRoute as error:
            self._failed = present, start, goal, clearance, error
            raise

    def revision_of(self, grid: OccupancyGrid) -> int:
        """Revision of what paths lead around."""
        return grid.revision if self.moving else grid.still_revision


class RoadRoutePlanner(RoutePlanner):
    """Base class of planners of paths over known roads, which are relations `connects` between places.

    Roads that are closed, such as by a door, are not used.

    class Fewest(RoadRoutePlanner):
        def search(self, graph, start, goal, lower_bound):
            return networkx.shortest_path(graph, start, goal)
    """

    @abstractmethod
    def search(self, graph: Any, start: str, goal: str, lower_bound: Callable[[str, str], float]) -> list[str]:
        """Search for the cheapest path; returns the names of its nodes.

        Args:
            graph: networkx DiGraph; the `weight` of an edge is its cost.
            start: First node.
            goal: Last node.
            lower_bound: Function from two nodes to a lower bound of the cost between them.

        Raises:
            networkx.NetworkXNoPath: There is no path.
        """

    def __init__(self, knowledge: Knowledge) -> None:
        super().__init__(knowledge)
        self._kept: tuple[Any, Point, Route] | None = None  # roads, goal, path

    def route(self, start: Pose2, goal: Pose2, clearance: float) -> list[Point]:
        """Plan a path over roads that are wide enough for the robot and the clearance on both sides.

        While the roads, their costs and the goal are unchanged and the robot is near the last path, the same list is
        returned. A mission may therefore call this repeatedly; it gets a new path when a road closes or opens.

        Raises:
            NoRoute: No open road leads to the goal; the message lists the closed roads.
        """
        width = self.knowledge.graph.attributes(self.knowledge.agent).get("width", 0.0)
        roads = Roadmap(self.knowledge, width + 2.0 * clearance)
        if self._kept is not None:
            known, towards, kept = self._kept
            if (
                known == roads.graph.adj
                and towards == goal[:2]
                and distance_to_path(start[:2], kept.points) <= MAX_PATH_DISTANCE
            ):
                return kept.points
        try:
            found = roads.route(start[:2], goal[:2], self.search)
        except KnowledgeError as error:
            raise NoRoute(str(error)) from error
        if found is None:
            closed = f"; closed: {', '.join(roads.closed)}" if roads.closed else ""
            raise NoRoute(f"no open road leads to the goal{closed}")
        self._kept = roads.graph.adj, goal[:2], found
        return found.points

    @property
    def last_route(self) -> Route | None:
        """Last path that `route` returned, with its places and its cost; None before the first."""
        return None if self._kept is None else self._kept[2]


def distance_to_path(point: Point, path: Sequence[Point]) -> float:
    """Distance of a point from the nearest leg of a path [m]."""
    return min(segment_distance(point, a, b) for a, b in pairwise(path)) if len(path) > 1 else math.dist(point, path[0])
