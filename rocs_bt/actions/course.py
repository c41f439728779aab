"""Course: prediction of a peer's motion from its recent displacement.

A prediction from the momentary turn rate would be wrong several seconds ahead.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from ..base.geometry import Pose2, Twist2
from ..control.locomotion import Array

SPAN = 1.0
"""Length of the time window in which the displacement is measured [s]."""

WATCHED = 0.3
"""Minimum time of observation for a displacement [s]; after a longer gap between observations it begins again."""


class Course:
    """Straight-line prediction of a peer's motion from its mean velocity over the last `SPAN`."""

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
        """Predict poses of the peer after the last observation.

        Args:
            twist: Velocity of the peer, body frame; used until the peer has been observed for `WATCHED`.
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
