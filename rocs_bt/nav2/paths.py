"""Actions of Nav2 that edit a path."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base.geometry import Pose2
from ..plan.context import mission_of
from ..trees.nodes import FAILURE, SUCCESS, Input, Instant, Outcome, Output
from ..trees.nodes.node import LazyAttribute
from .costs import Costmap
from .lenient import Framed, Lenient, Served
from .path import PathInput, PathSearch, headed, poses_in, within
from .poses import PoseInput, known, pose_of, robot_pose


class TruncatePath(Lenient, Instant):
    """Removes the poses at the end of a path that are nearer to its last pose than a distance; two poses remain."""

    input_path = PathInput(None, "path")
    output_path = Output(object, "path without its end")
    distance = Input(float, 1.0, "distance from the end [m]")

    def update(self) -> Outcome:
        path, away = list(poses_in(self.input_path)), self.distance
        end = path[-1] if path else None
        while end is not None and len(path) > 2 and path[-1].distance(end) < away:
            path.pop()
        if end is not None and path[-1] is not end:
            last = path[-1]
            path[-1] = last._replace(yaw=math.atan2(end.y - last.y, end.x - last.x))
        self.output_path = path
        return SUCCESS


class TruncatePathLocal(Lenient, Instant):
    """Cuts out the part of a path around the robot; FAILURE while the robot's pose is unknown."""

    input_path = PathInput(None, "path")
    output_path = Output(object, "part of the path")
    distance_forward = Input(float, 8.0, "length of the part after the nearest pose [m]; negative for the whole rest")
    distance_backward = Input(float, 4.0, "length of the part before the nearest pose [m]")
    robot_base_frame = Input(str, "base_link", "frame in Nav2; not used")
    robot_frame = Input(str, "base_link", "name of `robot_base_frame` before Lyrical; for a running Nav2 only")
    transform_tolerance = Input(float, 0.2, "tolerance in Nav2 [s]; for a running Nav2 only")
    pose = PoseInput(None, "pose of the robot; that of Knowledge by default")
    angular_distance_weight = Input(float, 0.0, "weight of the angle between the orientations [m/rad]")
    max_robot_pose_search_dist = Input(float, math.inf, "length that is searched after the pose found before [m]")
    _search: Any = LazyAttribute(lambda node: PathSearch())
    whole_rest = True
    """Whether a negative `distance_forward` means the whole rest; before Lyrical it means the nearest pose only."""

    def update(self) -> Outcome:
        mission, given = mission_of(self), self.pose
        pose = known(robot_pose(mission)) if given is None else pose_of(mission, given)
        if pose is None:
            return FAILURE
        path = poses_in(self.input_path)
        if path:
            limit, weight = self.max_robot_pose_search_dist, self.angular_distance_weight
            at = self._search.find(path, pose, max(limit, 0.0), weight, last=True)
            forward = self.distance_forward
            ahead = math.inf if forward < 0.0 and self.whole_rest else forward
            first = at + 1 - within(path[at::-1], self.distance_backward)
            path = path[first : at + within(path[at:], ahead)]
        self.output_path = path
        return SUCCESS


class ConcatenatePaths(Lenient, Instant):
    """Concatenates two paths; FAILURE if both are empty."""

    input_path1 = PathInput(None, "first path")
    input_path2 = PathInput(None, "second path")
    output_path = Output(object, "both paths")

    def update(self) -> Outcome:
        path = [*poses_in(self.input_path1), *poses_in(self.input_path2)]
        if not path:
            return FAILURE
        self.output_path = path
        return SUCCESS


class GetPoseFromPath(Lenient, Instant):
    """Pose of a path; FAILURE if it has no such pose."""

    path = PathInput(None, "path")
    index = Input(int, 0, "index of the pose; negative ones count from the end")
    pose = Output(Pose2, "pose")

    def update(self) -> Outcome:
        path, index = poses_in(self.path), self.index
        if not -len(path) <= index < len(path):
            return FAILURE
        self.pose = path[index]
        return SUCCESS


class GetCurrentPose(Framed, Instant):
    """Pose of the robot; FAILURE while it is unknown."""

    current_pose = Output(Pose2, "pose")

    def update(self) -> Outcome:
        pose = known(robot_pose(mission_of(self)))
        if pose is None:
            return FAILURE
        self.current_pose = pose
        return SUCCESS


KEEP, STRAIGHTEN, ENOUGH, MOST = 0.2, 0.3, 1e-4, 500
"""Weights of the original positions and of straightness, end of the iterations [m], and their maximum number."""

IN_COLLISION, INVALID_PATH = 503, 505
"""Error codes of Nav2's smoother server."""


class SmoothPath(Served, Instant):
    """Smooths a path between its ends; FAILURE, without a change of the outputs, if it is empty or then collides."""

    unsmoothed_path = PathInput(None, "path")
    max_smoothing_duration = Input(float, 3.0, "maximum duration in Nav2 [s]; for a running Nav2 only")
    check_for_collisions = Input(bool, False, "whether a path that collides is a failure")
    smoother_id = Input(str, "", "name of a smoother; for a running Nav2 only")
    smoothed_path = Output(object, "smoothed path")
    smoothing_duration = Output(float, "always 0 s: smoothing takes no simulated time")
    was_completed = Output(bool, "always true")

    def update(self) -> Outcome:
        path = poses_in(self.unsmoothed_path)
        if len(path) < 2:
            return self._fail(INVALID_PATH, "the path is empty" if not path else "the path has only one pose")
        smooth = smoothed(path)
        if self.check_for_collisions and Costmap.of(mission_of(self)).collisions(smooth):
            return self._fail(IN_COLLISION, "the smoothed path collides with an obstacle of the map")
        self.smoothed_path, self.smoothing_duration, self.was_completed = smooth, 0.0, True
        self.put_error()
        return SUCCESS

    def _fail(self, code: int, message: str) -> Outcome:
        self.put_error(code, message)
        self.feedback_message = message
        return FAILURE


def smoothed(path: list[Pose2]) -> list[Pose2]:
    """Smooth a path by gradient descent on its curvature and on the distance from the given poses; the ends stay."""
    given = np.array([pose[:2] for pose in path])
    points = given.copy()
    for _ in range(MOST if len(path) > 2 else 0):
        straight = points[:-2] + points[2:] - 2.0 * points[1:-1]
        change = KEEP * (given[1:-1] - points[1:-1]) + STRAIGHTEN * straight
        points[1:-1] += change
        if np.abs(change).max() < ENOUGH:
            break
    found = headed([(float(x), float(y)) for x, y in points])
    found[-1] = found[-1]._replace(yaw=path[-1].yaw)
    return found
