"""Path-planning actions of Nav2, implemented with the route planners in `planners/routes`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

from ...action import Failure, Reason
from ...errors import Fault, InputError
from ...geometry import Pose2
from ...knowledge import Roadmap
from ...trees.nodes import FAILURE, SUCCESS, Input, Instant, Outcome, Output
from ..context import mission_of
from ..route import NoRoute, Point, RoadRoutePlanner, RoutePlanner
from .poses import PoseInput, PosesInput, pose_of, poses_of, read_poses, robot_pose

CLEARANCE = 0.1
"""Minimum gap between the robot's hull and known obstacles [m]."""

GENERIC = ("", "GridBased")
"""Values of `planner_id` that name no planner: `grid_astar` is used if the robot builds a map, else `visibility`."""

UNKNOWN, INVALID_PLANNER, TF_ERROR, NO_VALID_PATH, NO_VIAPOINTS = 0, 1, 2, 8, 9
"""Error codes of Nav2's planner server, minus 200 for a path to one goal, or 300 for a path through several."""


class Server(Instant):
    """Base of nodes that call an action server in Nav2; here they compute in the process and ignore the address."""

    server_name = Input(str, "", "address of the server in Nav2; not used")
    server_timeout = Input(float, 0.0, "timeout of the server in Nav2 [ms]; not used")
    error_code_id = Output(int, "error code of nav2_msgs, 0 for none")
    error_msg = Output(str, "error message")


class Planning(Server):
    """Base of nodes that compute a path with a route planner and keep its state until a costmap is cleared."""

    base = 200
    tf_error: ClassVar[int] = TF_ERROR
    invalid_planner: ClassVar[int] = INVALID_PLANNER

    start = PoseInput(None, "start of the path; the robot's pose by default")
    planner_id = Input(str, "", "name of a file in planners/routes; chosen automatically if `GridBased` or empty")
    path = Output(list, "corners of the path, (x, y) in the world frame [m]")

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        if self.key("planner_id") is None and self.planner_id not in GENERIC:
            try:
                mission_of(self).content.load_route(self.planner_id)
            except InputError as error:
                yield from (("planner_id", fault) for fault in error.faults)

    def _start(self) -> Pose2 | None:
        mission = mission_of(self)
        given = self.start
        if given is None:
            here = robot_pose(mission)
            return None if math.isnan(here.x) else here
        return pose_of(mission, given)

    def _compute(self, goals: Sequence[Any]) -> Outcome:
        start = self._start()
        if start is None:
            return self._fail(self.tf_error, Failure(Reason.LOST_POSE))
        corners: list[Point] = []
        for goal in goals:
            try:
                found = self._planner().route(start, goal, CLEARANCE)
            except NoRoute as error:
                return self._fail(self.no_route(), Failure(Reason.BLOCKED, str(error)))
            except InputError as error:
                return self._fail(self.invalid_planner, Failure.cannot(error))
            corners += [(x, y) for x, y in found][1 if corners else 0 :]
            start = goal
        self.path, self.error_code_id, self.error_msg = corners, 0, ""
        self.feedback_message = f"{len(corners) - 1} legs"
        return SUCCESS

    def no_route(self) -> int:
        """Error code to report if the planner found no route."""
        return NO_VALID_PATH

    def _planner(self) -> RoutePlanner:
        mission, name = mission_of(self), self.planner_id
        if name in GENERIC:
            name = "visibility" if mission.knowledge.world.occupancy is None else "grid_astar"
        planners = route_planners(mission)
        if name not in planners:
            planners[name] = mission.content.load_route(name)(mission.knowledge)
        return planners[name]

    def _fail(self, code: int, failure: Failure) -> Outcome:
        self.error_code_id, self.error_msg = self.base + code, str(failure)
        self.feedback_message = str(failure)
        return FAILURE


def route_planners(mission: Any) -> dict[str, RoutePlanner]:
    """Route planners of a mission by name; all nodes share them, as they share a planner server in Nav2."""
    found: dict[str, RoutePlanner] = mission.shared.setdefault("nav2 planners", {})
    return found


class ComputePathToPose(Planning):
    """Computes a path from the robot to a goal; FAILURE with an error code if there is none."""

    goal = PoseInput("{goal}", "goal")
    use_start = Input(bool, True, "whether to use `start` if given")

    def update(self) -> Outcome:
        goal = self.goal
        found = pose_of(mission_of(self), goal)
        if found is None:
            return self._fail(UNKNOWN, Failure(Reason.NO_GOAL, f"the position of '{goal}' is unknown"))
        return self._compute([found])

    def _start(self) -> Pose2 | None:
        if not self.use_start:
            mission = mission_of(self)
            here = robot_pose(mission)
            return None if math.isnan(here.x) else here
        return super()._start()


class ComputePathThroughPoses(Planning):
    """Computes a path from the robot through several goals to the last one."""

    base = 300
    goals = PosesInput("{goals}", "goals in order")

    def update(self) -> Outcome:
        given = self.goals
        names = read_poses(given) if isinstance(given, str) else given
        if not names:
            return self._fail(NO_VIAPOINTS, Failure(Reason.NO_GOAL, "the list of goals is empty"))
        goals = poses_of(mission_of(self), names)
        if None in goals:
            unknown = names[goals.index(None)]
            return self._fail(UNKNOWN, Failure(Reason.NO_GOAL, f"the position of '{unknown}' is unknown"))
        return self._compute(goals)


class ClearEntireCostmap(Server):
    """Resets the route planners' state; there is no costmap here."""

    service_name = Input(str, "", "address of the service in Nav2; not used")

    def update(self) -> Outcome:
        route_planners(mission_of(self)).clear()
        return SUCCESS


class ClearCostmapExceptRegion(ClearEntireCostmap):
    """Same as ClearEntireCostmap."""

    reset_distance = Input(float, 1.0, "size of the region in Nav2 [m]; not used")


class ClearCostmapAroundRobot(ClearCostmapExceptRegion):
    """Same as ClearEntireCostmap."""


class TruncatePath(Instant):
    """Removes a length from the end of a path."""

    input_path = Input(list, doc="path")
    output_path = Output(list, "path without its end")
    distance = Input(float, 1.0, "length to remove [m]")

    def update(self) -> Outcome:
        left, path = self.distance, list(self.input_path)
        while len(path) > 1 and left > 0.0:
            (ax, ay), (bx, by) = path[-2][:2], path[-1][:2]
            leg = math.dist((ax, ay), (bx, by))
            path.pop()
            if leg > left:
                share = left / leg
                path.append((bx + share * (ax - bx), by + share * (ay - by)))
            left -= leg
        self.output_path = path
        return SUCCESS


class ConcatenatePaths(Instant):
    """Concatenates two paths."""

    input_path1 = Input(list, doc="first path")
    input_path2 = Input(list, doc="second path")
    output_path = Output(list, "both paths")

    def update(self) -> Outcome:
        first, second = list(self.input_path1), list(self.input_path2)
        self.output_path = first + second[1 if first and second and first[-1] == second[0] else 0 :]
        return SUCCESS if first or second else FAILURE


class GetPoseFromPath(Instant):
    """Pose at a corner of a path, heading along the path."""

    path = Input(list, doc="path")
    index = Input(int, 0, "index of the corner; negative ones count from the end")
    pose = Output(Pose2, "pose")

    def update(self) -> Outcome:
        path, index = list(self.path), self.index
        if not -len(path) <= index < len(path):
            return FAILURE
        at = index % len(path)
        legs = list(pairwise(path))
        (ax, ay), (bx, by) = legs[min(at, len(legs) - 1)] if legs else ((0.0, 0.0), (0.0, 0.0))
        x, y = path[at][:2]
        self.pose = Pose2(x, y, math.atan2(by - ay, bx - ax))
        return SUCCESS


class GetCurrentPose(Instant):
    """Pose of the robot; FAILURE while it is unknown."""

    global_frame = Input(str, "map", "frame in Nav2; here the world frame")
    robot_base_frame = Input(str, "base_link", "frame in Nav2; not used")
    current_pose = Output(Pose2, "pose")

    def update(self) -> Outcome:
        mission = mission_of(self)
        pose = robot_pose(mission)
        if math.isnan(pose.x):
            return FAILURE
        self.current_pose = pose
        return SUCCESS


class RemovePassedGoals(Instant):
    """Removes goals from the beginning of a list while the robot is near the first one."""

    input_goals = PosesInput("{goals}", "goals in order")
    output_goals = Output(list, "remaining goals")
    radius = Input(float, 0.5, "distance at which a goal counts as passed [m]")
    robot_base_frame = Input(str, "base_link", "frame in Nav2; not used")

    def update(self) -> Outcome:
        mission = mission_of(self)
        given = self.input_goals
        goals = list(given) if not isinstance(given, str) else [part.strip() for part in given.split(";")]
        here = robot_pose(mission)
        while len(goals) > 1 and (pose := pose_of(mission, goals[0])) is not None:
            if not here.distance(pose) <= self.radius:
                break
            goals.pop(0)
        self.output_goals = goals
        return SUCCESS


class _Selector(Instant):
    """Base of nodes that write their default value; in Nav2, a user can choose another one by a topic."""

    topic_name = Input(str, "", "topic in Nav2; not used")

    def update(self) -> Outcome:
        what = type(self).tag.removesuffix("Selector")
        what = "".join(f"_{c.lower()}" if c.isupper() else c for c in what).strip("_")
        self.write(f"selected_{what}", self.read(f"default_{what}"))
        return SUCCESS


class PlannerSelector(_Selector):
    """Writes `default_planner` to `selected_planner`."""

    default_planner = Input(str, doc="name of the planner")
    selected_planner = Output(str, "the same")


class ControllerSelector(_Selector):
    """Writes `default_controller` to `selected_controller`."""

    default_controller = Input(str, doc="name of the controller")
    selected_controller = Output(str, "the same")


class GoalCheckerSelector(_Selector):
    """Writes `default_goal_checker` to `selected_goal_checker`."""

    default_goal_checker = Input(str, doc="name of the goal checker")
    selected_goal_checker = Output(str, "the same")


class ProgressCheckerSelector(_Selector):
    """Writes `default_progress_checker` to `selected_progress_checker`."""

    default_progress_checker = Input(str, doc="name of the progress checker")
    selected_progress_checker = Output(str, "the same")


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


class ComputeRoute(Planning):
    """Computes a route over known roads with `planners/routes/dijkstra.py`."""

    base = 400
    tf_error: ClassVar[int] = 1
    invalid_planner: ClassVar[int] = UNKNOWN

    planner_id = Input(str, "dijkstra", "name of a route planner over roads in planners/routes; not a port of Nav2")
    start = PoseInput(None, "start of the route if `use_poses` and `use_start`")
    goal = PoseInput("{goal}", "goal if `use_poses`")
    goal_id = PoseInput("", "name of the goal place if not `use_poses`")
    start_id = PoseInput("", "name of the start place if not `use_poses`; the robot's position by default")
    use_poses = Input(bool, False, "whether to use `start` and `goal` instead of `start_id` and `goal_id`")
    use_start = Input(bool, False, "whether to use `start`; otherwise the route begins at the robot")
    route = Output(Route, "places and roads of the route")
    planning_time = Output(float, "always 0 s: planning takes no simulated time")

    def update(self) -> Outcome:
        mission = mission_of(self)
        goal = self.goal if self.use_poses else self.goal_id
        self.planning_time = 0.0
        found = pose_of(mission, goal)
        if found is None:
            failure = Failure(Reason.NO_GOAL, f"the position of '{goal}' is unknown")
            return self._fail(INDETERMINANT_NODES, failure)
        start = self._given_start()
        if start is not None and pose_of(mission, start) is None:
            failure = Failure(Reason.NO_GOAL, f"the position of the start '{start}' is unknown")
            return self._fail(INDETERMINANT_NODES, failure)
        outcome = self._compute([found])
        if outcome is SUCCESS:
            self.route = self._route()
        return outcome

    def no_route(self) -> int:
        roads = Roadmap(mission_of(self).knowledge)
        return NO_VALID_ROUTE if roads.graph.edges or roads.closed else NO_VALID_GRAPH

    def _given_start(self) -> object:
        """Start of the route as given by the ports; None if the route begins at the robot."""
        if self.use_poses:
            return self.start if self.use_start else None
        return self.start_id or None

    def _start(self) -> Pose2 | None:
        mission, start = mission_of(self), self._given_start()
        if start is not None:
            return pose_of(mission, start)
        here = robot_pose(mission)
        return None if math.isnan(here.x) else here

    def _route(self) -> Route:
        """Last route of the planner; empty if the planner does not use roads."""
        planner = self._planner()
        found = planner.last_route if isinstance(planner, RoadRoutePlanner) else None
        if found is None:
            return Route(0.0, (), ())
        return Route(found.cost, tuple(found.places), tuple(pairwise(found.places)))
