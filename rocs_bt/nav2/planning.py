"""Path-planning actions of Nav2, implemented with the route planners in `planners/routes`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, ClassVar

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2
from ..interfaces.action import Failure, Reason
from ..plan.context import mission_of
from ..plan.route import NoRoute, Point, RoutePlanner
from ..trees.nodes import FAILURE, SUCCESS, Instant, Outcome, Output
from .costs import Costmap
from .lenient import Served
from .path import ComputedPath
from .poses import PosesText, PoseText, known, pose_of, poses_of, read_poses, robot_pose

CLEARANCE = 0.1
"""Minimum gap between the robot's hull and known obstacles [m]."""

GENERIC = ("", "GridBased")
"""Values of `planner_id` that name no planner: `grid_astar` is used if the robot builds a map, else `visibility`."""

UNKNOWN, INVALID_PLANNER, TF_ERROR, START_OCCUPIED, GOAL_OCCUPIED, NO_VALID_PATH, NO_VIAPOINTS = 0, 1, 2, 5, 6, 8, 9
"""Error codes of Nav2's planner server, minus 200 for a path to one goal, or 300 for a path through several.

The others do not occur here: the robot's map has no edge (3, 4), and planning takes no simulated time (7).
"""


class Planning(Served):
    """Base of nodes that compute a path with a route planner and keep its state until a costmap is cleared."""

    base = 200
    tf_error: ClassVar[int] = TF_ERROR
    invalid_planner: ClassVar[int] = INVALID_PLANNER

    start: Annotated[PoseText, "start of the path; the robot's pose by default"] = None
    planner_id: Annotated[str, "name of a file in planners/routes; chosen automatically if `GridBased` or empty"] = ""
    path: Annotated[Output[Any], "path: poses, world frame, each 0.05 m; empty after a failure"]

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        if self.key("planner_id") is None and self.planner_id not in GENERIC:
            try:
                mission_of(self).content.load_route(self.planner_id)
            except InputError as error:
                yield from (("planner_id", fault) for fault in error.faults)

    def _start(self) -> Pose2 | None:
        mission = mission_of(self)
        given = self.start
        return known(robot_pose(mission)) if given is None else pose_of(mission, given)

    def _compute(self, goals: Sequence[Pose2]) -> Outcome:
        start = self._start()
        if start is None:
            return self._fail(self.tf_error, Failure(Reason.LOST_POSE))
        corners: Sequence[Point] = ()
        for goal in goals:
            try:
                found = self._planner().route(start, goal, CLEARANCE)
            except NoRoute as error:
                code, what = self.no_route(start, goal)
                return self._fail(code, Failure(Reason.BLOCKED, f"{what}{error}"))
            except InputError as error:
                return self._fail(self.invalid_planner, Failure.cannot(error))
            # The planner's own list is kept: the robot goes on along a path that the planner has not changed.
            corners = [*corners, *found[1:]] if corners else found
            start = goal
        self.path = ComputedPath.along(corners, goals[-1].yaw)
        self.put_error()
        self.feedback_message = f"{len(corners) - 1} legs"
        return SUCCESS

    def no_route(self, start: Pose2, goal: Pose2) -> tuple[int, str]:
        """Error code to report if the planner found no route, and a text before the planner's reason."""
        costmap = Costmap.of(mission_of(self))
        for code, pose, what in ((GOAL_OCCUPIED, goal, "goal"), (START_OCCUPIED, start, "start")):
            if costmap.collisions([pose]):
                return code, f"the {what} is occupied: "
        return NO_VALID_PATH, ""

    def _planner(self) -> RoutePlanner:
        mission, name = mission_of(self), self.planner_id
        if name in GENERIC:
            name = "visibility" if mission.knowledge.world.occupancy is None else "grid_astar"
        planners = route_planners(mission)
        if name not in planners:
            planners[name] = mission.content.load_route(name)(mission.knowledge)
        return planners[name]

    def _fail(self, code: int, failure: Failure) -> Outcome:
        self.path = ComputedPath()
        self.put_error(self.base + code, str(failure))
        self.feedback_message = str(failure)
        return FAILURE


def route_planners(mission: Any) -> dict[str, RoutePlanner]:
    """Route planners of a mission by name; all nodes share them, as they share a planner server in Nav2."""
    found: dict[str, RoutePlanner] = mission.shared.setdefault("nav2 planners", {})
    return found


class ComputePathToPose(Planning, Instant):
    """Computes a path from the robot to a goal; FAILURE with an error code if there is none."""

    goal: Annotated[PoseText, "goal"] = "{goal}"
    use_start: Annotated[bool, "whether to use `start` if given"] = True
    viapoints: Annotated[PosesText, "poses that the path should pass; for a running Nav2 only"] = None

    def update(self) -> Outcome:
        goal = self.goal
        if goal is None or goal == "":
            return self._fail(self.tf_error, Failure(Reason.NO_GOAL, "there is no goal"))
        found = pose_of(mission_of(self), goal)
        if found is None:
            return self._fail(UNKNOWN, Failure(Reason.NO_GOAL, f"the position of '{goal}' is unknown"))
        return self._compute([found])

    def _start(self) -> Pose2 | None:
        return super()._start() if self.use_start else known(robot_pose(mission_of(self)))


class ComputePathThroughPoses(Planning, Instant):
    """Computes a path from the robot through several goals to the last one; FAILURE if a part of it is missing."""

    base = 300
    goals: Annotated[PosesText, "goals in order"] = "{goals}"
    last_reached_index: Annotated[Output[int], "always -1, which means all goals: there are no partial paths here"]

    def update(self) -> Outcome:
        given = self.goals
        names = read_poses(given) if isinstance(given, str) else given
        self.last_reached_index = -1
        if not names:
            return self._fail(NO_VIAPOINTS, Failure(Reason.NO_GOAL, "the list of goals is empty"))
        goals = poses_of(mission_of(self), names)
        missing = [name for name, goal in zip(names, goals, strict=True) if goal is None]
        if missing:
            return self._fail(UNKNOWN, Failure(Reason.NO_GOAL, f"the position of '{missing[0]}' is unknown"))
        return self._compute([goal for goal in goals if goal is not None])
