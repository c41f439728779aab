"""Plain values of ROS messages for Nav2: poses and paths."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

from ...errors import Fault, InputError
from ...geometry import Pose2
from ..context import MissionContext
from ..nav2.path import poses_in
from ..nav2.poses import pose_of, robot_pose


class Posed(Protocol):
    """Node with a mission and a frame."""

    @property
    def mission(self) -> MissionContext | None: ...
    @property
    def frame(self) -> str: ...


def stamped(node: Posed, value: Any) -> dict[str, Any]:
    """PoseStamped of a place, in the frame of a node.

    Args:
        node: Node with the mission.
        value: Pose, text of a PoseStamped, or name of a place in the world model.

    Raises:
        InputError: The pose is not known.
    """
    mission = node.mission
    pose = None if mission is None or value is None else pose_of(mission, value)
    if mission is None or pose is None or not math.isfinite(pose.x + pose.y):
        raise InputError(Fault(f"the pose of '{value}' is not known." if value else "there is no goal."))
    if math.isnan(pose.yaw):  # any heading: that of the straight line from the robot
        here = robot_pose(mission)
        yaw = math.atan2(pose.y - here.y, pose.x - here.x)
        pose = Pose2(pose.x, pose.y, yaw if math.isfinite(yaw) else 0.0)
    return stamped_message(pose, node.frame)


def stamped_message(pose: Pose2, frame: str) -> dict[str, Any]:
    """Plain values of a geometry_msgs/PoseStamped; its stamp is 0, which means the latest transform.

    Args:
        pose: Pose in the frame.
        frame: Name of the frame.
    """
    position, turned = {"x": pose.x, "y": pose.y}, {"z": math.sin(pose.yaw / 2.0), "w": math.cos(pose.yaw / 2.0)}
    return {"header": {"frame_id": frame}, "pose": {"position": position, "orientation": turned}}


def path_message(value: Any, frame: str) -> Mapping[str, Any]:
    """Plain values of a nav_msgs/Path.

    Args:
        value: Plain values of one; or corners, (x, y) in the frame [m], each of which gets the heading of the leg that
            begins there.
        frame: Name of the frame.

    Raises:
        InputError: The value is neither, or the path is empty.
    """
    if isinstance(value, Mapping):
        return value
    if not isinstance(value, Sequence) or isinstance(value, str) or not value:
        raise InputError(Fault(f"{value!r:.60} is no path.", hint="Write the key of a path."))
    return {"header": {"frame_id": frame}, "poses": [stamped_message(pose, frame) for pose in poses_in(value)]}


def corners_of(path: Mapping[str, Any]) -> list[tuple[float, float]]:
    """Positions of a nav_msgs/Path, (x, y) in its frame [m]."""
    positions: Iterable[Any] = (pose["pose"]["position"] for pose in path.get("poses", ()))
    return [(float(p["x"]), float(p["y"])) for p in positions]
