"""When a path's end is reached."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..geometry import Pose2, Twist2
from .path import Path


@dataclass(frozen=True)
class GoalApproach:
    """A robot has arrived when it is close to the end, has the way behind it, and is slow.

    The arc length counts too, so that a round trip does not end where it begins. A robot that stands beside the goal
    farther than `distance` with nothing of the path left will not get closer by following it: plan a new path.

    Attributes:
        distance: To the path's end, straight and along the path [m].
        speed: Forward or sideways [m/s].
        turn: Turn rate [rad/s].
    """

    distance: float = 0.05
    speed: float = 0.05
    turn: float = 0.2

    def reached(self, path: Path, s: float, pose: Pose2, twist: Twist2) -> bool:
        """Whether the robot has arrived.

        Args:
            path: What it followed.
            s: Its arc length there, such as `PathReference.s` [m].
            pose: Where it is, in the world frame.
            twist: How it moves, in its body frame.
        """
        x, y, _, _ = path.look(path.length)
        return (
            path.length - s <= self.distance
            and math.hypot(pose.x - x, pose.y - y) <= self.distance
            and math.hypot(twist.forward, twist.left) <= self.speed
            and abs(twist.turn) <= self.turn
        )
