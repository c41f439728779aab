"""Heading: the yaw of a robot that moves along a path, as the motion actions declare it."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2, wrap_angle
from ..base.units import ANGLE, parse_quantity
from ..control.heading import toward
from ..control.locomotion import Array, Locomotion
from ..interfaces.action import Body
from .pose import goal_pose

ALONG = "along"
"""Heading along the path, the default."""

LOOK_AT = "look_at"

FACING = math.radians(5.0)
"""Maximum yaw error of an arrived robot with an angle as heading [rad]."""

MOVED = 0.05
"""Displacement of a place to look at that triggers new yaws [m]."""


def looked_at(text: str) -> str:
    """Node in the heading `look_at PLACE`; empty for any other text."""
    words = text.split(maxsplit=1)
    return words[1].strip() if len(words) == 2 and words[0] == LOOK_AT else ""


class Heading:
    """Yaw of a robot on its path: along the path, the yaw at the start, a fixed angle, or toward a place.

    Args:
        text: `along`, `keep`, an angle such as `90 deg`, world frame, or `look_at PLACE`.

    Attributes:
        kept: Yaw of the heading `keep`, world frame [rad]; None before the first `yaws`.
        place: Node to look at; empty for other headings.

    Raises:
        InputError: The text is none of these.
    """

    def __init__(self, text: str) -> None:
        self.kept: float | None = None
        self._looked: Pose2 | None = None
        self._angle: float | None = None
        self.place = looked_at(text)
        self._kind: Literal["along", "fixed", "look_at"] = "fixed"
        if text == ALONG:
            self._kind = "along"
        elif self.place:
            self._kind = "look_at"
        elif text != "keep":
            self.kept = self._angle = _angle(text)

    @property
    def along(self) -> bool:
        """Whether the robot faces along its path."""
        return self._kind == "along"

    def misfit(self, locomotion: Locomotion) -> str:
        """Reason why a body cannot have this heading; empty if it can."""
        if self.along or "vy" in locomotion.axes:
            return ""
        return f"a '{locomotion.kind}' locomotion cannot move sideways, so its heading is always '{ALONG}'"

    def yaws(self, body: Body, positions: Array, pose: Pose2) -> Array:
        """Yaws at positions on a path, world frame, without jumps of 2 pi, shape (n,) [rad]; not for `along`.

        Args:
            body: Robot.
            positions: Positions in the order in which they are passed, world frame, shape (n, 2) [m].
            pose: Present pose of the robot, world frame.

        Raises:
            ActionFailed: NO_GOAL, if the position of the place is not known.
        """
        if self._kind == "look_at":
            at = self._looked = goal_pose(body, self.place)
            return toward(positions, at.x, at.y, pose.yaw)
        if self.kept is None:
            self.kept = pose.yaw
        return np.full(len(positions), self.kept)

    def faces(self, pose: Pose2) -> bool:
        """Whether the yaw of a pose is within `FACING` of an angle; true for other headings."""
        return self._angle is None or abs(wrap_angle(self._angle - pose.yaw)) <= FACING

    def changed(self, body: Body) -> bool:
        """Whether the place has moved by more than `MOVED` since the last `yaws`.

        Raises:
            ActionFailed: NO_GOAL, if the position of the place is not known.
        """
        return self._looked is not None and self._looked.distance(goal_pose(body, self.place)) > MOVED


def _angle(text: str) -> float:
    try:
        quantity = parse_quantity(text)
    except InputError:
        quantity = None
    if quantity is None or quantity.dimension != ANGLE or not math.isfinite(quantity.value):
        expected = f"'{ALONG}', 'keep', an angle such as '90 deg', or '{LOOK_AT} PLACE'"
        raise InputError(Fault(f"heading must be {expected}, found '{text}'."))
    return quantity.value
