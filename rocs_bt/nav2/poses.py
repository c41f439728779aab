"""Poses in ports of Nav2's nodes, written as names of places in the world model or as texts of a PoseStamped."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2, yaw_of
from ..trees.nodes import Syntax
from ..trees.value import from_string
from .path import pose_in

if TYPE_CHECKING:
    from ..plan.context import MissionContext

STAMPED = 9
"""Number of fields of a PoseStamped text: stamp, frame, position x y z, orientation x y z w, separated by `;`."""


def read_pose(text: str) -> str | Pose2:
    """Convert a text to a pose, or return it as the name of a node in the world model.

    Raises:
        InputError: A field of a PoseStamped is not a finite number.
    """
    parts = text.split(";")
    if len(parts) != STAMPED:
        return text.strip()
    fields = [from_string(part.strip(), float) for part in parts[2:]]
    if not all(map(math.isfinite, fields)):
        raise InputError(
            Fault(f"the pose '{text}' contains a field that is not finite.", hint="Write seven finite numbers.")
        )
    x, y, _, qx, qy, qz, qw = fields
    return Pose2(x, y, yaw_of(qw, qx, qy, qz))


def read_poses(text: str) -> list[str | Pose2]:
    """Convert a text to poses, or to names of nodes in the world model.

    Raises:
        InputError: The text has PoseStamped fields, but not nine per pose.
    """
    parts = [part.strip() for part in text.split(";") if part.strip()]
    if len(parts) % STAMPED == 0 and parts and parts[0].lstrip("-").isdigit():
        return [read_pose(";".join(parts[i : i + STAMPED])) for i in range(0, len(parts), STAMPED)]
    return list(parts)


PoseText = Annotated[Any, Syntax(read_pose, names_places=True)]
"""Port that reads a pose: the name of a node in the world model, or the text of a PoseStamped."""

PosesText = Annotated[Any, Syntax(read_poses, names_places=True)]
"""Port that reads several poses: a list, or names of nodes in the world model separated by `;`."""


def robot_pose(mission: MissionContext) -> Pose2:
    """Current pose of the robot, world frame; its coordinates are NaN while unknown."""
    return mission.knowledge.robot.pose(mission.clock.now())


def pose_of(mission: MissionContext, value: Any) -> Pose2 | None:
    """Pose that a port's value describes, world frame; None if its position is unknown or the value is empty.

    Args:
        mission: Mission with the knowledge that contains the node.
        value: Pose, text of a PoseStamped, or name of a node in the world model.

    Raises:
        InputError: The value is none of these.
    """
    if isinstance(value, str):
        value = read_pose(value)
    if value is None or value == "" or value == []:
        return None
    if isinstance(value, Mapping):
        return pose_in(value)
    if isinstance(value, Pose2):
        return value if math.isfinite(value.x + value.y) else None
    if isinstance(value, str):
        return mission.knowledge.world.pose_of(value)
    raise InputError(Fault(f"{value!r} is not a pose.", hint="Write the name of a place, or a PoseStamped."))


def poses_of(mission: MissionContext, value: Any) -> list[Pose2 | None]:
    """Poses that the value of a port with several poses describes; see `pose_of`."""
    return [pose_of(mission, each) for each in list_of(value)]


def list_of(value: Any) -> list[Any]:
    """Items of the value of a port with several poses; a message such as nav_msgs/Goals is the list in it."""
    if isinstance(value, str):
        return list(read_poses(value))
    if isinstance(value, Mapping):
        value = next((items for items in value.values() if isinstance(items, (list, tuple))), ())
    return list(value or ())


def known(pose: Pose2) -> Pose2 | None:
    """The pose, or None if its position is unknown (NaN)."""
    return None if math.isnan(pose.x) else pose


def same(one: Any, other: Any) -> bool:
    """Whether two lists of poses are equal, where NaN, which marks an irrelevant heading, is equal to NaN."""
    return repr(one) == repr(other)
