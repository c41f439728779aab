"""What the keys of several tables have in common: names, positions, poses, a planner's latency."""

from __future__ import annotations

import math
from typing import Annotated

from ..base.geometry import Pose2, wrap_angle
from ..base.units import ANGLE, LENGTH, TIME, Bounds
from ..declare import Keys, OneOf, Valid, Value, Word
from ..interfaces.vocabulary import dialects
from ..knowledge.declaration import is_name


def _is_name(text: str) -> bool:
    return text.strip() == text and is_name(text)


Name = Annotated[str, Valid(_is_name, "a valid name", "Use 1 to 200 printable characters without spaces around.")]
Identifier = Valid(str.isidentifier, "a valid body name", "Use letters, digits and '_', beginning with a letter.")

Coordinate = Annotated[float, LENGTH, Bounds(-1e4, 1e4)]
Size = Annotated[float, LENGTH, Bounds(0.0, 1e4)]
At = Annotated[float, TIME, Bounds(0.0, 86400.0)]
Delay = Annotated[float, TIME, Bounds(0.0, 60.0)]

Latency = Annotated[Delay | None, Word("measured")]
"""Planning time of a planner [s], simulated; None (`measured` in files) for the measured one."""

Dialect = Annotated[str, OneOf(dialects())]
"""Dialect of a mission in XML; empty to recognise it."""


class PoseKeys(Value):
    """Keys of a pose in the world frame.

    Attributes:
        x, y: Position [m].
        yaw: Heading [rad].
    """

    x: Coordinate
    y: Coordinate
    yaw: Annotated[float, ANGLE, Bounds(-1e4, 1e4)] = 0.0

    def _made(self) -> Pose2:
        """The pose."""
        return Pose2(self.x, self.y, self.yaw if math.isinf(self.yaw) else wrap_angle(self.yaw))


class PlaceKeys(PoseKeys):
    """Keys of a pose of which the heading may be any: it is then NaN."""

    yaw: Annotated[float, ANGLE, Bounds(-1e4, 1e4)] = math.nan


class JitterKeys(Value):
    """Half-widths of the noise on a start pose.

    Attributes:
        x, y: Half-width of the position [m].
        yaw: Half-width of the heading [rad].
    """

    x: Size = 0.0
    y: Size = 0.0
    yaw: Annotated[float, ANGLE, Bounds(0.0, math.pi)] = 0.0

    def _made(self) -> Pose2:
        """The half-widths."""
        return Pose2(self.x, self.y, self.yaw)


Pose = Annotated[Pose2, Keys(PoseKeys, here=True)]
Jitter = Annotated[Pose2, Keys(JitterKeys)]
