"""Predicted course of a peer from its recent displacement.

The momentary turn rate does not predict its position several seconds ahead.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from ..control.drive import Array
from ..geometry import Pose2, Twist2

SPAN = 1.0
"""Time window of the displacement [s]."""

WATCHED = 0.3
"""Minimum observation time for a displacement; a gap this long between observations restarts it [s]."""


class Course:
    """Straight-line prediction of a peer from its mean velocity over the last `SPAN`."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, Pose2]] = deque()

    def note(self, t: float, pose: Pose2) -> None:
        """Add an observation of the peer.

        Args:
            t: Time of the observation [s]; a gap of more than `WATCHED` discards the earlier ones.
            pose: Pose of the peer, world frame.
        """
        if self._seen and t - self._seen[-1][0] > WATCHED:
            self._seen.clear()
        self._seen.append((t, pose))
        while t - self._seen[0][0] > SPAN + 1e-9:
            self._seen.popleft()

    def ahead(self, twist: Twist2, times: Array) -> Array:
        """Predicted poses after the last observation.

        Args:
            twist: Velocity of the peer, used until it has been observed for `WATCHED`.
            times: Times after the last observation, shape (n,) [s].

        Returns:
            Poses with constant yaw, world frame, shape (n, 3) [m, m, rad].
        """
        (begun, first), (t, here) = self._seen[0], self._seen[-1]
        watched = t - begun
        vx, vy = twist.forward * math.cos(here.yaw), twist.forward * math.sin(here.yaw)
        if watched >= WATCHED - 1e-9:
            vx, vy = (here.x - first.x) / watched, (here.y - first.y) / watched
        return np.stack([here.x + vx * times, here.y + vy * times, np.full_like(times, here.yaw)], axis=1)
