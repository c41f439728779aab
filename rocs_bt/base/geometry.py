"""Poses and twists in the plane and in space.

World frame: x east, y north, z up. Body frame: x forward, y left, z up, origin at the centre of the drive axle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import NamedTuple


def wrap_angle(angle: float) -> float:
    """Wrap an angle to (-pi, pi] [rad]."""
    wrapped = math.remainder(angle, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


def yaw_of(w: float, i: float, j: float, k: float) -> float:
    """Yaw of a unit quaternion, in (-pi, pi] [rad]."""
    return wrap_angle(math.atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k)))


class Pose2(NamedTuple):
    """Planar pose: position and heading, world frame (x east, y north).

    Attributes:
        x: Position to the east [m].
        y: Position to the north [m].
        yaw: Heading in (-pi, pi]; 0 is east, left positive [rad].
    """

    x: float
    y: float
    yaw: float = 0.0

    def distance(self, other: Pose2) -> float:
        """Distance to the position of another pose [m]."""
        return math.hypot(other.x - self.x, other.y - self.y)

    def bearing(self, other: Pose2) -> float:
        """Bearing of another pose's position: angle from this pose's heading to it, left positive [rad]."""
        return wrap_angle(math.atan2(other.y - self.y, other.x - self.x) - self.yaw)

    def transform(self, x: float, y: float) -> tuple[float, float]:
        """Convert a point from the body frame of this pose to the world frame [m]."""
        here_x, here_y, yaw = self
        c, s = math.cos(yaw), math.sin(yaw)
        return here_x + c * x - s * y, here_y + s * x + c * y

    def compose(self, other: Pose2) -> Pose2:
        """Convert a pose from the body frame of this pose to the world frame."""
        x, y = self.transform(other.x, other.y)
        return pose2((x, y, wrap_angle(self.yaw + other.yaw)))


class Twist2(NamedTuple):
    """Planar velocity, body frame (x forward, y left).

    Attributes:
        forward: Speed ahead; negative backward [m/s].
        turn: Turn rate, left positive [rad/s].
        left: Speed to the left; 0 for drives that cannot go sideways [m/s].
    """

    forward: float
    turn: float = 0.0
    left: float = 0.0

    @property
    def up(self) -> float:
        """Vertical velocity: zero [m/s]."""
        return 0.0


class Pose3(NamedTuple):
    """Pose in space: position and orientation, world frame.

    The body turns by `roll` about x, then `pitch` about y, then `yaw` about z: fixed axes of the world (REP 103).
    """

    x: float  # [m]
    y: float  # [m]
    z: float  # [m]
    roll: float = 0.0  # [rad], in (-pi, pi]
    pitch: float = 0.0  # [rad], in [-pi/2, pi/2], nose down positive
    yaw: float = 0.0  # [rad], in (-pi, pi]

    @property
    def plane(self) -> Pose2:
        """Pose in the plane: x, y and yaw."""
        return pose2((self.x, self.y, self.yaw))

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """Orientation as a unit quaternion (w, x, y, z)."""
        (r, s), (p, q), (c, t) = ((math.cos(a / 2.0), math.sin(a / 2.0)) for a in (self.roll, self.pitch, self.yaw))
        return r * p * c + s * q * t, s * p * c - r * q * t, r * q * c + s * p * t, r * p * t - s * q * c

    @property
    def tilt(self) -> float:
        """Angle between the body's z axis and the vertical [rad], in [0, pi]."""
        return math.acos(math.cos(self.roll) * math.cos(self.pitch))

    @classmethod
    def from_quaternion(cls, position: Sequence[float], quaternion: Sequence[float]) -> Pose3:
        """Pose from a position (x, y, z) [m] and a unit quaternion (w, x, y, z)."""
        (x, y, z), (w, i, j, k) = position, quaternion
        roll = math.atan2(2.0 * (w * i + j * k), 1.0 - 2.0 * (i * i + j * j))
        pitch = math.asin(min(1.0, max(-1.0, 2.0 * (w * j - k * i))))
        return cls(x, y, z, wrap_angle(roll), pitch, yaw_of(w, i, j, k))


class Twist3(NamedTuple):
    """Velocity of a body that can also climb: body frame, with `up` and `turn` along and about the vertical."""

    forward: float  # [m/s]
    left: float = 0.0  # [m/s]
    up: float = 0.0  # [m/s]
    turn: float = 0.0  # [rad/s], left positive

    @property
    def plane(self) -> Twist2:
        """Velocity in the plane: forward, turn and left."""
        return twist2((self.forward, self.turn, self.left))


pose2: Callable[[tuple[float, float, float]], Pose2] = partial(tuple.__new__, Pose2)
"""Fast constructor of a Pose2 from (x, y, yaw), which takes half the usual time; for code that creates many poses."""

twist2: Callable[[tuple[float, float, float]], Twist2] = partial(tuple.__new__, Twist2)
"""Fast constructor of a Twist2 from (forward, turn, left)."""


def along_arc(pose: Pose2, twist: Twist2, duration: float) -> Pose2:
    """Pose after a constant body twist has acted for a duration [s] (Lynch and Park, Modern Robotics, 13.3)."""
    return arc(pose, twist, (duration,))[0]


def arc(pose: Pose2, twist: Twist2, durations: Sequence[float]) -> list[Pose2]:
    """Poses along the arc of a constant body twist, after each of several durations [s]."""
    (_, _, yaw), (_, turn, _) = pose, twist
    positions = arc_positions(pose, twist, durations)
    return [pose2((x, y, wrap_angle(yaw + turn * t))) for (x, y), t in zip(positions, durations, strict=True)]


def arc_positions(pose: Pose2, twist: Twist2, durations: Iterable[float]) -> list[tuple[float, float]]:
    """Positions along the arc of a constant body twist [m], after each of several durations [s]."""
    x, y, yaw = pose
    forward, turn, left = twist
    c, s = math.cos(yaw), math.sin(yaw)
    found = []
    for duration in durations:
        angle = turn * duration
        # sin(a)/a and (1 - cos(a))/a, with limits 1 and 0 at zero.
        along, across = (math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle) if abs(angle) > 1e-9 else (1.0, 0.0)
        ahead, aside = forward * duration, left * duration
        dx, dy = along * ahead - across * aside, across * ahead + along * aside
        found.append((x + c * dx - s * dy, y + s * dx + c * dy))
    return found
