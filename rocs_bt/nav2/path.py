"""Geometry of paths: sequences of poses, as in nav_msgs/Path.

A path on the blackboard is a list of poses. Nodes also accept corners (x, y) [m], which get the heading of the leg that
begins there, and plain values of a nav_msgs/Path.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate, pairwise
from typing import Any, Final

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2, wrap_angle, yaw_of
from ..plan.route import Point

STEP: Final = 0.05
"""Maximum distance of the poses of a computed path [m]: the resolution of Nav2's costmaps."""


MOST_POSES: Final = 20_000
"""Maximum number of poses of a computed path, about; a path of more than 1 km has a greater distance between them."""


class ComputedPath(list[Pose2]):
    """Path of a route planner."""

    corners: Sequence[Point] = ()  # the same object while the planner keeps its path

    @classmethod
    def along(cls, corners: Sequence[Point], yaw: float) -> ComputedPath:
        """Path along corners (x, y) [m], with a pose at least each `STEP`.

        Args:
            corners: Corners as the planner returned them.
            yaw: Heading at the end [rad]; NaN for that of the last leg.
        """
        made = cls(headed(_dense([(float(c[0]), float(c[1])) for c in corners])))
        if made and math.isfinite(yaw):
            made[-1] = made[-1]._replace(yaw=yaw)
        made.corners = corners
        return made


def poses_in(value: Any) -> list[Pose2]:
    """Poses of a path; empty for None or an empty path.

    Args:
        value: Poses; corners (x, y) or (x, y, yaw) [m, rad]; or plain values of a nav_msgs/Path.

    Raises:
        InputError: The value is none of these.
    """
    if isinstance(value, Mapping):
        return [pose_in(pose) for pose in value.get("poses", ())]
    if isinstance(value, str) and not value:
        return []
    if isinstance(value, str) or not isinstance(value, (Iterable, type(None))):
        raise InputError(Fault(f"{value!r:.60} is no path.", hint="Write the key of a path."))
    points = list(value or ())
    if all(isinstance(point, Pose2) for point in points):
        return points
    try:
        if all(len(point) > 2 for point in points):
            return [Pose2(*map(float, point[:3])) for point in points]
        return headed([(float(point[0]), float(point[1])) for point in points])
    except (TypeError, ValueError, IndexError, KeyError) as error:
        raise InputError(Fault(f"{value!r:.60} is no path.", hint="Write the key of a path.")) from error


def corners_of(value: Any) -> Sequence[Sequence[float]]:
    """Corners of a path, for the robot's actions: those of its planner, or the positions of its poses."""
    if isinstance(value, ComputedPath):
        return value.corners
    return value if isinstance(value, list) else [pose[:2] for pose in poses_in(value)]


def pose_in(message: Mapping[str, Any]) -> Pose2:
    """Pose of the plain values of a geometry_msgs/PoseStamped or Pose."""
    pose = message.get("pose", message)
    position, turned = pose.get("position", {}), pose.get("orientation", {})
    yaw = yaw_of(float(turned.get("w", 1.0)), *(float(turned.get(axis, 0.0)) for axis in "xyz"))
    return Pose2(float(position.get("x", 0.0)), float(position.get("y", 0.0)), yaw)


def headed(points: Sequence[Point]) -> list[Pose2]:
    """Poses at points [m], each with the heading of the leg that begins there; the last has that of the last leg."""
    yaws = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(points)] or [0.0]
    return [Pose2(x, y, yaw) for (x, y), yaw in zip(points, [*yaws, yaws[-1]], strict=False)]


def _dense(points: Sequence[Point]) -> list[Point]:
    found, total = list(points[:1]), sum(math.dist(a, b) for a, b in pairwise(points))
    step = max(STEP, total / MOST_POSES)
    for (ax, ay), (bx, by) in pairwise(points):
        count = max(1, math.ceil(math.dist((ax, ay), (bx, by)) / step - 1e-9))
        found += [(ax + (bx - ax) * i / count, ay + (by - ay) * i / count) for i in range(1, count)]
        found.append((bx, by))
    return found


def length(path: Sequence[Pose2]) -> float:
    """Length of a path [m]."""
    return sum(a.distance(b) for a, b in pairwise(path))


def within(path: Sequence[Pose2], limit: float) -> int:
    """Number of poses before the first with a summed length from the beginning above a limit [m]; at least 1."""
    lengths = accumulate(a.distance(b) for a, b in pairwise(path))
    return next((i for i, total in enumerate(lengths, 1) if total > limit), len(path))


def nearest(path: Sequence[Pose2], pose: Pose2, weight: float = 0.0, *, last: bool = False) -> int:
    """Index of the pose of a path that is nearest to a pose.

    Args:
        path: Path with at least one pose.
        pose: Pose, such as that of the robot.
        weight: Weight of the angle between the orientations, beside the distance [m/rad].
        last: Whether the last of equally near poses is meant, not the first.
    """
    away = [math.hypot(pose.distance(each), weight * wrap_angle(each.yaw - pose.yaw)) for each in path]
    least = min(away)
    return len(away) - 1 - away[::-1].index(least) if last else away.index(least)


class PathSearch:
    """Search of the pose of a path that is nearest to the robot, from the pose that was found before.

    A limited search begins at the pose found before, and at the beginning of a path that has changed.
    """

    def __init__(self) -> None:
        self._path: Any = None
        self._from = 0

    def find(self, path: list[Pose2], pose: Pose2, limit: float, weight: float = 0.0, *, last: bool = False) -> int:
        """Index of the nearest pose.

        Args:
            path: Path with at least one pose.
            pose: Pose of the robot.
            limit: Length of the part of the path that is searched [m]; infinite or negative for the whole path.
            weight: Weight of the angle, see `nearest`.
            last: Whether the last of equally near poses is meant.
        """
        if not 0.0 <= limit < math.inf:
            return nearest(path, pose, weight, last=last)
        if path != self._path:
            self._path, self._from = path, 0
        ahead = path[self._from :]
        self._from += nearest(ahead[: within(ahead, limit)], pose, weight, last=last)
        return self._from
