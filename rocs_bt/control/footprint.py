"""Rectangular footprint of a robot, and its distances to points.

A gap is the signed distance of one point to the hull, negative inside. The clearance of a pose is its smallest gap to
any point. The contact time is the time after which a moving robot has a point inside its hull.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError
from ..base.geometry import Twist2
from .locomotion import Array

GROUP = 4
"""Number of consecutive poses for which the nearest points are searched together."""

CLOSING = 0.008
"""Minimum approach of a point that is inside already to count as contact [m]; else the robot passes it."""


@dataclass(frozen=True)
class Footprint:
    """Outline of a robot from above: a rectangle centred on the base.

    Attributes:
        length: Size along the robot [m].
        width: Size across the robot [m].

    Raises:
        InputError: A side is not a positive number.
    """

    length: float
    width: float

    def __post_init__(self) -> None:
        if not (0.0 < self.length < math.inf and 0.0 < self.width < math.inf):
            raise InputError(f"a footprint needs a positive length and width, found {self.length} m, {self.width} m.")

    @property
    def inner(self) -> float:
        """Radius of the inscribed circle [m]."""
        return 0.5 * min(self.length, self.width)

    @property
    def outer(self) -> float:
        """Radius of the circumscribed circle [m]."""
        return 0.5 * math.hypot(self.length, self.width)

    def gap(self, x: Array, y: Array) -> Array:
        """Signed distances of points x, y, body frame, each of shape (...,), to the hull [m]; negative inside."""
        # In place: for thousands of points, new arrays cost more than the arithmetic.
        ahead, aside = np.asarray(np.abs(x), float), np.asarray(np.abs(y), float)
        ahead -= 0.5 * self.length
        aside -= 0.5 * self.width
        inside = np.minimum(np.maximum(ahead, aside), 0.0)
        gaps: Array = np.hypot(np.maximum(ahead, 0.0, out=ahead), np.maximum(aside, 0.0, out=aside), out=ahead)
        gaps += inside
        return gaps

    def clearance(self, poses: Array, points: Array) -> Array:
        """Distance of the hull to the nearest point, at each pose.

        Args:
            poses: Poses, world frame, shape (k, 3) [m, m, rad].
            points: Points, world frame, shape (m, 2) [m].

        Returns:
            Gaps, shape (k,) [m]; negative if a point is inside, +inf without points.
        """
        if len(points) == 0 or len(poses) == 0:
            return np.full(len(poses), np.inf)
        groups = np.minimum(np.arange(-(-len(poses) // GROUP) * GROUP).reshape(-1, GROUP), len(poses) - 1)
        middle = poses[groups[:, GROUP // 2]]
        moved = np.hypot(*(poses[groups] - middle[:, None])[..., :2].transpose(2, 0, 1)).max(axis=1)
        dx, dy = points[:, 0] - middle[:, :1], points[:, 1] - middle[:, 1:2]
        away = dx * dx + dy * dy
        # Points beyond this distance cannot be the nearest at any heading of the hull.
        reach = np.sqrt(away.min(axis=1)) + 2.0 * moved + self.outer - self.inner + 1e-9
        group, near = np.nonzero(away <= (reach * reach)[:, None])
        at, (x, y) = poses[groups[group]], points[near].T[:, :, None]
        c, s, dx, dy = np.cos(at[..., 2]), np.sin(at[..., 2]), x - at[..., 0], y - at[..., 1]
        gaps = self.gap(c * dx + s * dy, c * dy - s * dx)
        least: Array = np.minimum.reduceat(gaps, np.searchsorted(group, np.arange(len(groups)))).reshape(-1)
        return least[: len(poses)]

    def contact_time(self, points: Array, twist: Twist2, times: Array) -> float:
        """Predict when a point touches the hull, for a robot that moves with constant twist.

        A point that is already inside counts only once it has come nearer by `CLOSING`, so that a robot close to an
        obstacle can leave or pass it.

        Args:
            points: Points around the robot, body frame, shape (m, 2) [m].
            twist: Velocity of the robot, body frame.
            times: Times to check, from now on, ascending, shape (k,) [s].

        Returns:
            Time of contact [s]; +inf without contact.
        """
        poses = poses_ahead(twist, times)
        low, high = poses[:, :2].min(axis=0, initial=0.0), poses[:, :2].max(axis=0, initial=0.0)
        near = points[((points >= low - self.outer) & (points <= high + self.outer)).all(axis=1)]
        if len(near) == 0:
            return math.inf
        c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        dx, dy = near[:, 0] - poses[:, :1], near[:, 1] - poses[:, 1:2]
        return first_contact(times, self.gap(c * dx + s * dy, c * dy - s * dx), self.gap(*near.T))


def poses_ahead(twist: Twist2, times: Array) -> Array:
    """Poses after times [s] of motion with a constant twist, in the body frame of now, shape (k, 3) [m, m, rad]."""
    turn = twist.turn * times
    # sin(a)/a and (1 - cos(a))/a, with limits 1 and 0 at zero: see geometry.along_arc.
    small = np.abs(turn) < 1e-6
    safe = np.where(small, 1.0, turn)
    along, across = np.where(small, 1.0, np.sin(safe) / safe), np.where(small, 0.0, (1.0 - np.cos(safe)) / safe)
    forward, left = twist.forward * times, twist.left * times
    return np.column_stack([along * forward - across * left, across * forward + along * left, turn])


def first_contact(times: Array, gaps: Array, now: Array) -> float:
    """First of the times, shape (k,) [s], at which one of the gaps is negative; +inf if none is.

    A gap that is negative already counts only once it has shrunk by `CLOSING`.

    Args:
        times: Times, ascending, shape (k,) [s].
        gaps: Gap of each obstacle at each time, shape (k, m) [m].
        now: Gap of each obstacle at present, shape (m,) [m].
    """
    touched = (gaps < np.where(now > 0.0, 0.0, now - CLOSING)).any(axis=1)
    return float(times[touched.argmax()]) if touched.any() else math.inf
