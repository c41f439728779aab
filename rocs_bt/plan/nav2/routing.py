"""Nav2's ComputeRoute, on the roads that the robot knows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

from ...action import Failure, Reason
from ...geometry import Pose2
from ...knowledge import Roadmap
from ...trees.nodes import SUCCESS, Input, Outcome, Output
from ..context import mission_of
from ..route import RoadRoutePlanner
from .planning import Planning
from .poses import PoseInput, pose_of, robot_pose

UNKNOWN, TF_ERROR, NO_VALID_GRAPH, INDETERMINANT_NODES, NO_VALID_ROUTE = 0, 1, 2, 3, 5
"""Error codes of the route server, from 400."""


@dataclass(frozen=True)
class Route:
    """Route over the roads, as in nav2_msgs/Route.

    Attributes:
        route_cost: Length, weighted by the cost of each road [m].
        nodes: Names of the places, in order.
        edges: Roads between them, each as the names of its ends.
    """

    route_cost: float
    nodes: tuple[str, ...]
    edges: tuple[tuple[str, str], ...]


class ComputeRoute(Planning):
    """Computes a route over the roads that the robot knows, by `planners/routes/dijkstra.py`."""

    base = 400
    tf_error: ClassVar[int] = TF_ERROR
    invalid_planner: ClassVar[int] = UNKNOWN

    planner_id = Input(str, "dijkstra", "name of a route planner over roads in planners/routes; not a port of Nav2")
    start = PoseInput(None, "where the route begins, if `use_poses` and `use_start`")
    goal = PoseInput("{goal}", "where to, if `use_poses`")
    goal_id = PoseInput("", "name of the place to go to, if not `use_poses`")
    start_id = PoseInput("", "name of the place to begin at, if not `use_poses`; where the robot is by default")
    use_poses = Input(bool, False, "whether `start` and `goal` count, not `start_id` and `goal_id`")
    use_start = Input(bool, False, "whether `start` counts; else the route begins where the robot is")
    route = Output(Route, "places and roads of the route")
    planning_time = Output(float, "always 0 s: planning takes no simulated time")

    def update(self) -> Outcome:
        mission = mission_of(self)
        goal = self.goal if self.use_poses else self.goal_id
        self.planning_time = 0.0
        found = pose_of(mission, goal)
        if found is None:
            failure = Failure(Reason.NO_GOAL, f"nothing knows where '{goal}' is")
            return self._fail(INDETERMINANT_NODES, failure)
        start = self._given_start()
        if start is not None and pose_of(mission, start) is None:
            failure = Failure(Reason.NO_GOAL, f"nothing knows where the start '{start}' is")
            return self._fail(INDETERMINANT_NODES, failure)
        outcome = self._through([found])
        if outcome is SUCCESS:
            self.route = self._route()
        return outcome

    def no_route(self) -> int:
        roads = Roadmap(mission_of(self).knowledge)
        return NO_VALID_ROUTE if roads.graph.edges or roads.closed else NO_VALID_GRAPH

    def _given_start(self) -> object:
        """The start that the ports give; None where the route begins at the robot."""
        if self.use_poses:
            return self.start if self.use_start else None
        return self.start_id or None

    def _begins(self) -> Pose2 | None:
        mission, start = mission_of(self), self._given_start()
        if start is not None:
            return pose_of(mission, start)
        here = robot_pose(mission)
        return None if math.isnan(here.x) else here

    def _route(self) -> Route:
        """The route that the planner has found last; empty for a planner that uses no roads."""
        planner = self._planner()
        way = planner.way if isinstance(planner, RoadRoutePlanner) else None
        if way is None:
            return Route(0.0, (), ())
        return Route(way.cost, tuple(way.places), tuple(pairwise(way.places)))
