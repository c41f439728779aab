"""Poses as Nav2's nodes read them from files and boards: names of nodes of the world model, or PoseStamped texts."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ...errors import Fault, InputError
from ...geometry import Pose2
from ...trees.board import from_string
from ...trees.nodes import Input

if TYPE_CHECKING:
    from ..context import MissionContext

STAMPED = 9
"""Fields of Nav2's text of a PoseStamped: stamp, frame, position x y z, orientation x y z w, separated by `;`."""


class PoseInput(Input[Any]):
    """A port that reads a pose: the name of a node of the world model, or Nav2's text of a PoseStamped."""

    def __init__(self, default: Any, doc: str) -> None:
        super().__init__(object, default, doc, parse=read_pose)


class PosesInput(Input[Any]):
    """A port that reads several poses: a list, or names of nodes of the world model separated by `;`."""

    def __init__(self, default: Any, doc: str) -> None:
        super().__init__(object, default, doc, parse=read_poses)


def read_pose(text: str) -> str | Pose2:
    """The pose that a text holds, or the name of a node.

    Raises:
        InputError: A field of a PoseStamped is no number, or not finite.
    """
    parts = text.split(";")
    if len(parts) != STAMPED:
        return text.strip()
    fields = [from_string(part.strip(), float) for part in parts[2:]]
    if not all(map(math.isfinite, fields)):
        raise InputError(
            Fault(f"the pose '{text}' has a field that is not finite.", hint="Write seven finite numbers.")
        )
    x, y, _, qx, qy, qz, qw = fields
    return Pose2(x, y, math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz)))


def read_poses(text: str) -> list[str | Pose2]:
    """The poses or names in a text.

    Raises:
        InputError: A text of PoseStamped fields does not have nine for each pose.
    """
    parts = [part.strip() for part in text.split(";") if part.strip()]
    if len(parts) % STAMPED == 0 and parts and parts[0].lstrip("-").isdigit():
        return [read_pose(";".join(parts[i : i + STAMPED])) for i in range(0, len(parts), STAMPED)]
    return list(parts)


def robot_pose(mission: MissionContext) -> Pose2:
    """The present pose of the robot in the world frame; its coordinates are NaN while it is not known."""
    return mission.knowledge.robot.pose(mission.clock.now())


def pose_of(mission: MissionContext, value: Any) -> Pose2 | None:
    """Where a value is, in the world frame; None if nothing knows.

    Args:
        mission: The mission, whose knowledge is asked.
        value: A pose, its text, or the name of a node of the world model.

    Raises:
        InputError: The value is neither.
    """
    if isinstance(value, str):
        value = read_pose(value)
    if isinstance(value, Pose2):
        return value
    if isinstance(value, str):
        return mission.knowledge.world.pose_of(value)
    raise InputError(Fault(f"{value!r} is no pose.", hint="Write the name of a place, or a PoseStamped."))


def poses_of(mission: MissionContext, value: Any) -> list[Pose2 | None]:
    """Where several values are."""
    values = read_poses(value) if isinstance(value, str) else value
    return [pose_of(mission, each) for each in values or ()]


def same(one: Any, other: Any) -> bool:
    """Whether two lists of poses are equal; a heading that does not matter (NaN) equals itself."""
    return repr(one) == repr(other)
