"""Actions of Nav2 that edit a path."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np

from ..base.geometry import Pose2
from ..plan.context import mission_of
from ..trees.nodes import FAILURE, SUCCESS, Instant, Outcome, Output
from ..trees.nodes.node import LazyAttribute
from .costs import Costmap
from .lenient import Framed, Lenient, Served
from .path import PathSearch, headed, poses_in, within
from .poses import PoseText, known, pose_of, robot_pose


class TruncatePath(Lenient, Instant):
    """Removes the poses at the end of a path that are nearer to its last pose than a distance; two poses remain."""

    input_path: Annotated[Any, "path"] = None
    output_path: Annotated[Output[Any], "path without its end"]
    distance: Annotated[float, "distance from the end [m]"] = 1.0

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

    input_path: Annotated[Any, "path"] = None
    output_path: Annotated[Output[Any], "part of the path"]
    distance_forward: Annotated[float, "length of the part after the nearest pose [m]; negative for the rest"] = 8.0
    distance_backward: Annotated[float, "length of the part before the nearest pose [m]"] = 4.0
    robot_base_frame: Annotated[str, "frame in Nav2; not used"] = "base_link"
    robot_frame: Annotated[str, "name of `robot_base_frame` before Lyrical; for a running Nav2 only"] = "base_link"
    transform_tolerance: Annotated[float, "tolerance in Nav2 [s]; for a running Nav2 only"] = 0.2
    pose: Annotated[PoseText, "pose of the robot; that of Knowledge by default"] = None
    angular_distance_weight: Annotated[float, "weight of the angle between the orientations [m/rad]"] = 0.0
    max_robot_pose_search_dist: Annotated[float, "length that is searched after the pose found before [m]"] = math.inf
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

    input_path1: Annotated[Any, "first path"] = None
    input_path2: Annotated[Any, "second path"] = None
    output_path: Annotated[Output[Any], "both paths"]

    def update(self) -> Outcome:
        path = [*poses_in(self.input_path1), *poses_in(self.input_path2)]
        if not path:
            return FAILURE
        self.output_path = path
        return SUCCESS


class GetPoseFromPath(Lenient, Instant):
    """Pose of a path; FAILURE if it has no such pose."""

    path: Annotated[Any, "path"] = None
    index: Annotated[int, "index of the pose; negative ones count from the end"] = 0
    pose: Annotated[Output[Pose2], "pose"]

    def update(self) -> Outcome:
        path, index = poses_in(self.path), self.index
        if not -len(path) <= index < len(path):
            return FAILURE
        self.pose = path[index]
        return SUCCESS


class GetCurrentPose(Framed, Instant):
    """Pose of the robot; FAILURE while it is unknown."""

    current_pose: Annotated[Output[Pose2], "pose"]

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

    unsmoothed_path: Annotated[Any, "path"] = None
    max_smoothing_duration: Annotated[float, "maximum duration in Nav2 [s]; for a running Nav2 only"] = 3.0
    check_for_collisions: Annotated[bool, "whether a path that collides is a failure"] = False
    smoother_id: Annotated[str, "name of a smoother; for a running Nav2 only"] = ""
    smoothed_path: Annotated[Output[Any], "smoothed path"]
    smoothing_duration: Annotated[Output[float], "always 0 s: smoothing takes no simulated time"]
    was_completed: Annotated[Output[bool], "always true"]

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
