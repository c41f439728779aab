"""Poses and twists in the plane.

World frame: x east, y north. Body frame: x forward, y left, origin at the centre of the drive axle.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple


def wrap_angle(angle: float) -> float:
    """The angle in (-pi, pi] [rad] that points the same way."""
    wrapped = math.remainder(angle, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


class Pose2(NamedTuple):
    """A position and a heading in the world frame."""

    x: float  # [m]
    y: float  # [m]
    yaw: float = 0.0  # [rad], in (-pi, pi]

    def distance(self, other: Pose2) -> float:
        """How far the other position is [m]."""
        return math.hypot(other.x - self.x, other.y - self.y)

    def bearing(self, other: Pose2) -> float:
        """The angle from this heading to the other position, left positive [rad]."""
        return wrap_angle(math.atan2(other.y - self.y, other.x - self.x) - self.yaw)

    def transform(self, x: float, y: float) -> tuple[float, float]:
        """A point of this pose's body frame [m], in the world frame [m]."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return self.x + c * x - s * y, self.y + s * x + c * y

    def compose(self, other: Pose2) -> Pose2:
        """The other pose, given in this one's body frame, in the world frame."""
        x, y = self.transform(other.x, other.y)
        return Pose2(x, y, wrap_angle(self.yaw + other.yaw))


class Twist2(NamedTuple):
    """A velocity in the body frame."""

    forward: float  # [m/s]
    turn: float = 0.0  # [rad/s], left positive
    left: float = 0.0  # [m/s], zero for drives that cannot go sideways


def along_arc(pose: Pose2, twist: Twist2, duration: float) -> Pose2:
    """Where a constant body twist leads in a while [s] (Lynch and Park, Modern Robotics, 13.3)."""
    angle = twist.turn * duration
    # sin(a)/a and (1 - cos(a))/a, whose limits at zero are 1 and 0.
    along, across = (math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle) if abs(angle) > 1e-9 else (1.0, 0.0)
    forward, left = twist.forward * duration, twist.left * duration
    x, y = pose.transform(along * forward - across * left, across * forward + along * left)
    return Pose2(x, y, wrap_angle(pose.yaw + angle))


def arc(pose: Pose2, twist: Twist2, durations: Iterable[float]) -> list[Pose2]:
    """Where `along_arc` leads in each of some whiles [s], to the bit; in half the time for many of them."""
    yaw, turn = pose.yaw, twist.turn
    whiles = list(durations)
    places = arc_positions(pose, twist, whiles)
    return [Pose2(x, y, wrap_angle(yaw + turn * t)) for (x, y), t in zip(places, whiles, strict=True)]


def arc_positions(pose: Pose2, twist: Twist2, durations: Iterable[float]) -> list[tuple[float, float]]:
    """The positions alone of `arc` [m]."""
    x, y, yaw = pose
    forward, turn, left = twist
    c, s = math.cos(yaw), math.sin(yaw)
    found = []
    for duration in durations:
        angle = turn * duration
        along, across = (math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle) if abs(angle) > 1e-9 else (1.0, 0.0)
        ahead, aside = forward * duration, left * duration
        dx, dy = along * ahead - across * aside, across * ahead + along * aside
        found.append((x + c * dx - s * dy, y + s * dx + c * dy))
    return found
