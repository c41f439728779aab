"""Route actions of Nav2, on the roads of the world model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, ClassVar

from ..base.geometry import Pose2
from ..interfaces.action import Failure, Reason
from ..knowledge import Roadmap
from ..plan.context import mission_of
from ..plan.route import RoadRoutePlanner
from ..trees.nodes import FAILURE, RUNNING, SUCCESS, Instant, Outcome, Output
from .planning import UNKNOWN, Planning
from .poses import PoseText, known, pose_of, robot_pose
from .servers import Cancellable

NO_VALID_GRAPH, INDETERMINANT_NODES, NO_VALID_ROUTE = 2, 3, 5
"""Error codes of Nav2's route server, minus 400, in addition to `UNKNOWN`."""


@dataclass(frozen=True)
class Route:
    """Route over known roads, as in nav2_msgs/Route.

    Attributes:
        route_cost: Length of the route, weighted by the cost of each road [m].
        nodes: Names of the places on the route, in order.
        edges: Roads between these places, each as the names of its two ends.
    """

    route_cost: float
    nodes: tuple[str, ...]
    edges: tuple[tuple[str, str], ...]


class _Routing(Planning):
    """Base of nodes that compute a route over known roads with `planners/routes/dijkstra.py`."""

    base = 400
    tf_error: ClassVar[int] = 1
    invalid_planner: ClassVar[int] = UNKNOWN

    planner_id: Annotated[str, "name of a route planner over roads in planners/routes; not a port of Nav2"] = "dijkstra"
    start: Annotated[PoseText, "start of the route if `use_poses` and `use_start`"] = None
    goal: Annotated[PoseText, "goal if `use_poses`"] = "{goal}"
    goal_id: Annotated[PoseText, "name of the goal place if not `use_poses`"] = ""
    start_id: Annotated[PoseText, "name of the start place if not `use_poses`; the robot's position by default"] = ""
    use_poses: Annotated[bool, "whether to use `start` and `goal` instead of `start_id` and `goal_id`"] = False
    use_start: Annotated[bool, "whether to use `start`; otherwise the route begins at the robot"] = False
    route: Annotated[Output[Any], "places and roads of the route; None after a failure"]

    def compute(self) -> Outcome:
        """Compute the route, and write it with its path and the error code."""
        mission = mission_of(self)
        goal = self.goal if self.use_poses else self.goal_id
        found = None if goal in (None, "") else pose_of(mission, goal)
        if found is None:
            failure = Failure(Reason.NO_GOAL, f"the position of '{goal}' is unknown" if goal else "there is no goal")
            return self._fail(INDETERMINANT_NODES, failure)
        start = self._given_start()
        if start is not None and pose_of(mission, start) is None:
            failure = Failure(Reason.NO_GOAL, f"the position of the start '{start}' is unknown")
            return self._fail(INDETERMINANT_NODES, failure)
        outcome = self._compute([found])
        if outcome is SUCCESS:
            self.route = self._route()
        return outcome

    def no_route(self, start: Pose2, goal: Pose2) -> tuple[int, str]:
        roads = Roadmap(mission_of(self).knowledge)
        return NO_VALID_ROUTE if roads.graph.edges or roads.closed else NO_VALID_GRAPH, ""

    def _given_start(self) -> object:
        """Start of the route as given by the ports; None if the route begins at the robot."""
        if self.use_poses:
            return self.start if self.use_start else None
        return self.start_id or None

    def _start(self) -> Pose2 | None:
        mission, start = mission_of(self), self._given_start()
        return known(robot_pose(mission)) if start is None else pose_of(mission, start)

    def _route(self) -> Route:
        """Last route of the planner; empty if the planner does not use roads."""
        planner = self._planner()
        found = planner.last_route if isinstance(planner, RoadRoutePlanner) else None
        if found is None:
            return Route(0.0, (), ())
        return Route(found.cost, tuple(found.places), tuple(pairwise(found.places)))

    def _fail(self, code: int, failure: Failure) -> Outcome:
        self.route = Route(0.0, (), ())
        return super()._fail(code, failure)


class ComputeRoute(_Routing, Instant):
    """Computes a route over known roads with `planners/routes/dijkstra.py`."""

    planning_time: Annotated[Output[float], "always 0 s: planning takes no simulated time"]

    def update(self) -> Outcome:
        self.planning_time = 0.0
        return self.compute()


ARRIVED = 0.5
"""Distance at which the robot has arrived at a place of a route [m]."""


class ComputeAndTrackRoute(_Routing, Cancellable):
    """Computes a route, and is RUNNING until the robot has passed all its places; it does not drive.

    SUCCESS within 0.5 m of the last place. A changed goal or start gives a new route.
    """

    execution_duration: Annotated[Output[float], "time since the beginning [s]"]
    execution_time: Annotated[Output[float], "same as `execution_duration`: name of the port in Kilted's palette"]
    last_node_id: Annotated[Output[Any], "name of the place that the robot has passed last"]
    next_node_id: Annotated[Output[Any], "name of the place to which the robot drives"]
    current_edge_id: Annotated[Output[Any], "names of these two places"]
    rerouted: Annotated[Output[bool], "whether the route was computed again in this tick"]

    def initialise(self) -> None:
        super().initialise()
        self._since, self._passed = self.runtime.now(), 0
        self._inputs: tuple[Any, ...] | None = None

    def update(self) -> Outcome:
        if self.cancelled:
            self.put_error()
            return SUCCESS
        inputs = (self.use_poses, self.goal if self.use_poses else self.goal_id, self._given_start())
        self.rerouted = again = self._inputs is not None and inputs != self._inputs
        if self._inputs is None or again:
            self._inputs, self._passed = inputs, 0
            if self.compute() is FAILURE:
                return FAILURE
            self._places = self._route().nodes
        self.execution_duration = self.execution_time = self.runtime.now() - self._since
        return self._track()

    def terminate(self, new_status: Outcome) -> None:
        super().terminate(new_status)
        if new_status is not SUCCESS:
            self.route = Route(0.0, (), ())

    def wait_text(self) -> str:
        if self.status is not RUNNING:
            return self.feedback_message
        mission = mission_of(self)
        pose = pose_of(mission, name := self._places[self._passed])
        left = math.nan if pose is None else robot_pose(mission).distance(pose)
        return f"until the robot is within {ARRIVED:g} m of '{name}', {left:.1f} m away"

    def _track(self) -> Outcome:
        mission, places = mission_of(self), self._places
        here, count = robot_pose(mission), len(places)
        while self._passed < count:
            pose = pose_of(mission, places[self._passed])
            if pose is None or not here.distance(pose) <= ARRIVED:
                break
            self._passed += 1
        last, following = places[max(self._passed - 1, 0)] if places else "", places[self._passed : self._passed + 1]
        self.last_node_id, self.next_node_id = last, following[0] if following else last
        self.current_edge_id = (last, self.next_node_id)
        return SUCCESS if self._passed == count else RUNNING
