"""Nodes that call the planning, smoothing, route and following servers of a running Nav2."""

from __future__ import annotations

from typing import Any

from ...action import Failure
from ...ros_link import RosGoal
from ...trees.nodes import SUCCESS, Input, Outcome, Output
from ..nav2.path import PathInput
from ..nav2.poses import PoseInput, PosesInput, list_of
from .fields import duration
from .nav2_messages import path_message
from .nav2_servers import Nav2Action, Nav2Motion
from .uses_ros import parse_name


class ComputePathThroughPoses(Nav2Action):
    """Computes a path through several goals with Nav2's planner server."""

    type = "nav2_msgs/action/ComputePathThroughPoses"
    server_name = Input(str, "compute_path_through_poses", "name of the action", parse=parse_name)
    goals = PosesInput("{goals}", "goals in order")
    start = PoseInput(None, "start; the robot's pose by default")
    planner_id = Input(str, "", "name of a planner of Nav2; its default if empty")
    path = Output(object, "path, as nav_msgs/Path; empty after a failure")
    last_reached_index = Output(int, "index of the last goal that the path reaches; -1 for all")

    def fields(self) -> dict[str, Any]:
        start, goals = self.start, [self.stamped(goal) for goal in list_of(self.goals)]
        found = {"goals": self.array("goals", goals), "planner_id": self.planner_id, "use_start": bool(start)}
        return {**found, "start": self.stamped(start)} if start else found

    def on_result(self, goal: RosGoal) -> str:
        self.put_result(goal, "path", "last_reached_index")
        return super().on_result(goal)

    def failed(self, failure: Failure) -> Outcome:
        self.path = {}
        return super().failed(failure)


class SmoothPath(Nav2Action):
    """Smooths a path with Nav2's smoother server."""

    type = "nav2_msgs/action/SmoothPath"
    server_name = Input(str, "smooth_path", "name of the action", parse=parse_name)
    unsmoothed_path = PathInput(None, "path")
    max_smoothing_duration = Input(float, 3.0, "maximum duration [s]")
    check_for_collisions = Input(bool, False, "whether a path that collides is a failure")
    smoother_id = Input(str, "", "name of a smoother of Nav2; its default if empty")
    smoothed_path = Output(object, "smoothed path, as nav_msgs/Path")
    smoothing_duration = Output(object, "duration [s]")
    was_completed = Output(bool, "whether the smoother had enough time")

    def fields(self) -> dict[str, Any]:
        found = {name: self.read(name) for name in ("check_for_collisions", "smoother_id")}
        path, most = path_message(self.unsmoothed_path, self.frame), duration(self.max_smoothing_duration)
        return {**found, "path": path, "max_smoothing_duration": most}

    def on_result(self, goal: RosGoal) -> str:
        if goal.result is not None:
            self.smoothed_path = goal.result.get(("path",))
        self.put_result(goal, "smoothing_duration", "was_completed")
        return super().on_result(goal)


class AssistedTeleop(Nav2Motion):
    """Lets a person drive with Nav2's collision checks; a failure is SUCCESS unless `is_recovery`."""

    type = "nav2_msgs/action/AssistedTeleop"
    server_name = Input(str, "assisted_teleop", "name of the action", parse=parse_name)
    time_allowance = Input(float, 10.0, "maximum duration [s]")
    is_recovery = Input(bool, False, "whether a failure of the server is a failure of the node")

    def fields(self) -> dict[str, Any]:
        return {"time_allowance": duration(self.time_allowance)}

    def failed(self, failure: Failure) -> Outcome:
        sent, outcome = self._goal is not None, super().failed(failure)
        return SUCCESS if sent and not self.is_recovery else outcome


class _Route(Nav2Action):
    start = PoseInput(None, "start if `use_poses` and `use_start`")
    goal = PoseInput("{goal}", "goal if `use_poses`")
    start_id = Input(int, 0, "number of the start node")
    goal_id = Input(int, 0, "number of the goal node")
    use_start = Input(bool, False, "whether to use `start`; otherwise the route begins at the robot")
    use_poses = Input(bool, False, "whether to use the poses instead of the numbers")
    route = Output(object, "route, as nav2_msgs/Route")
    path = Output(object, "path, as nav_msgs/Path; empty after a failure")

    def fields(self) -> dict[str, Any]:
        found = {name: self.read(name) for name in ("start_id", "goal_id", "use_start", "use_poses")}
        if self.use_poses:
            found["goal"] = self.stamped(self.goal)
            if self.use_start:
                found["start"] = self.stamped(self.start)
        return found

    def failed(self, failure: Failure) -> Outcome:
        self.path, self.route = {}, {}
        return super().failed(failure)


class ComputeRoute(_Route):
    """Computes a route with Nav2's route server."""

    type = "nav2_msgs/action/ComputeRoute"
    server_name = Input(str, "compute_route", "name of the action", parse=parse_name)
    planning_time = Output(object, "duration [s]")

    def on_result(self, goal: RosGoal) -> str:
        self.put_result(goal, "route", "path", "planning_time")
        return super().on_result(goal)


class ComputeAndTrackRoute(_Route):
    """Computes a route with Nav2's route server, and is RUNNING until the robot has reached its end."""

    type = "nav2_msgs/action/ComputeAndTrackRoute"
    server_name = Input(str, "compute_and_track_route", "name of the action", parse=parse_name)
    execution_duration = Output(object, "duration [s]")
    execution_time = Output(object, "never written: name of the port in Kilted's palette")
    last_node_id = Output(int, "number of the node that the robot has passed last")
    next_node_id = Output(int, "number of the node to which the robot drives")
    current_edge_id = Output(int, "number of the edge on which the robot is")
    rerouted = Output(bool, "whether the route has changed")

    def on_feedback(self, goal: RosGoal) -> str:
        for name in ("route", "path", "last_node_id", "next_node_id", "current_edge_id", "rerouted"):
            if goal.feedback is not None:
                self.write(name, goal.feedback.get((name,)))
        return super().on_feedback(goal)

    def on_result(self, goal: RosGoal) -> str:
        self.put_result(goal, "execution_duration")
        return super().on_result(goal)


class FollowObject(Nav2Motion):
    """Follows a moving object with Nav2's following server."""

    type = "nav2_msgs/action/FollowObject"
    server_name = Input(str, "follow_object", "name of the action", parse=parse_name)
    pose_topic = Input(str, "dynamic_pose", "topic with the pose of the object")
    max_duration = Input(float, 0.0, "maximum duration [s]; without limit if 0")
    tracked_frame = Input(str, "", "frame of the object, if there is no topic")
    total_elapsed_time = Output(object, "duration [s]")

    def fields(self) -> dict[str, Any]:
        names = ("pose_topic", "tracked_frame")
        return {**{name: self.read(name) for name in names}, "max_duration": duration(self.max_duration)}

    def on_result(self, goal: RosGoal) -> str:
        self.put_result(goal, "total_elapsed_time")
        return super().on_result(goal)
