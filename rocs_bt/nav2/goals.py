"""Actions of Nav2 that edit a list of goals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any

from ..base.geometry import Pose2
from ..plan.context import mission_of
from ..trees.nodes import FAILURE, SUCCESS, Instant, Outcome, Output
from .costs import OccupancyTest
from .lenient import Framed, Lenient
from .poses import PosesText, PoseText, known, list_of, pose_of, robot_pose

PENDING, COMPLETED, SKIPPED = 0, 1, 2
"""States of a goal in nav2_msgs/WaypointStatus."""


@dataclass(frozen=True)
class WaypointStatus:
    """State of one goal, as in nav2_msgs/WaypointStatus.

    Attributes:
        waypoint_pose: Goal: its pose, or the name of a node of the world model.
        waypoint_status: PENDING 0, COMPLETED 1, SKIPPED 2 or FAILED 3.
        waypoint_index: Index of the goal in the list at the beginning.
        error_code: Error code of nav2_msgs.
        error_msg: Error message.
    """

    waypoint_pose: Any
    waypoint_status: int = PENDING
    waypoint_index: int = 0
    error_code: int = 0
    error_msg: str = ""


def pending(goals: Any) -> list[WaypointStatus]:
    """States of goals before any of them was passed."""
    return [WaypointStatus(goal, waypoint_index=i) for i, goal in enumerate(list_of(goals))]


class Statuses(Lenient):
    """Base of nodes that remove goals and write down what became of them."""

    input_waypoint_statuses: Annotated[Any, "states of all goals"] = None
    output_waypoint_statuses: Annotated[Output[Any], "states of all goals, those of the removed ones changed"]

    def mark(self, removed: list[Any], status: int) -> bool:
        """Change the states of removed goals and write all states; False if a removed goal is not pending."""
        given: Any = self.input_waypoint_statuses
        statuses: list[WaypointStatus] = list(given or ())
        for goal in removed if statuses else ():
            at = next(
                (i for i, s in enumerate(statuses) if s.waypoint_status == PENDING and s.waypoint_pose == goal), -1
            )
            if at < 0:
                return False
            statuses[at] = replace(statuses[at], waypoint_status=status)
        self.output_waypoint_statuses = statuses
        return True


class RemovePassedGoals(Statuses, Framed, Instant):
    """Removes goals from the beginning of a list while the robot is near the first one; the last one remains."""

    input_goals: Annotated[PosesText, "goals in order"] = "{goals}"
    output_goals: Annotated[Output[Any], "remaining goals"]
    radius: Annotated[float, "distance at which a goal counts as passed [m]"] = 0.5

    def update(self) -> Outcome:
        mission, goals, passed = mission_of(self), list_of(self.input_goals), list[Any]()
        here = known(robot_pose(mission))
        if goals and here is None:
            return FAILURE
        while len(goals) > 1 and here is not None and (pose := pose_of(mission, goals[0])) is not None:
            if not here.distance(pose) <= self.radius:
                break
            passed.append(goals.pop(0))
        if not self.mark(passed, COMPLETED):
            return FAILURE
        self.output_goals = goals
        return SUCCESS


class RemoveInCollisionGoals(Statuses, OccupancyTest, Instant):
    """Removes goals that are occupied in the robot's map; FAILURE for an empty list, or a goal without a pose."""

    input_goals: Annotated[PosesText, "goals in order"] = "{goals}"
    output_goals: Annotated[Output[Any], "goals that are free"]

    def update(self) -> Outcome:
        mission, goals = mission_of(self), list_of(self.input_goals)
        poses = [pose_of(mission, goal) for goal in goals]
        if not goals or None in poses:
            self.output_goals = goals
            return FAILURE
        blocked = [g for g, pose in zip(goals, poses, strict=True) if pose is not None and self.occupied(pose)]
        if not self.mark(blocked, SKIPPED):
            return FAILURE
        self.output_goals = [goal for goal in goals if goal not in blocked]
        return SUCCESS


class GetNextFewGoals(Lenient, Instant):
    """First goals of a list; FAILURE if the list is empty."""

    input_goals: Annotated[PosesText, "goals in order"] = None
    num_goals: Annotated[int, "number of goals"] = 1
    output_goals: Annotated[Output[Any], "first goals"]

    def update(self) -> Outcome:
        goals = list_of(self.input_goals)
        if not goals:
            return FAILURE
        self.output_goals = goals[: max(self.num_goals, 0)]
        return SUCCESS


class AppendGoalPoseToGoals(Lenient, Instant):
    """Appends a goal to a list."""

    goal_pose: Annotated[PoseText, "goal to append"] = None
    input_goals: Annotated[PosesText, "goals in order"] = None
    output_goals: Annotated[Output[Any], "goals with the appended one"]

    def update(self) -> Outcome:
        goal = self.goal_pose
        self.output_goals = [*list_of(self.input_goals), *([] if goal is None else [goal])]
        return SUCCESS


class ExtractRouteNodesAsGoals(Lenient, Instant):
    """Places of a route as goals with yaw 0; FAILURE if the route is empty."""

    route: Annotated[Any, "route of ComputeRoute"] = None
    goals: Annotated[Output[Any], "poses of its places"]

    def update(self) -> Outcome:
        mission, route = mission_of(self), self.route
        nodes = (route.get("nodes", ()) if isinstance(route, dict) else getattr(route, "nodes", ())) or ()
        poses = [_place(mission, node) for node in nodes]
        if not poses or None in poses:
            return FAILURE
        self.goals = [pose._replace(yaw=0.0) for pose in poses if pose is not None]
        return SUCCESS


def _place(mission: Any, node: Any) -> Pose2 | None:
    """Pose of a node of a route: a name in the world model, or plain values of a nav2_msgs/RouteNode."""
    if isinstance(node, dict):
        position = node.get("position", {})
        return Pose2(float(position.get("x", 0.0)), float(position.get("y", 0.0)))
    return pose_of(mission, node)
