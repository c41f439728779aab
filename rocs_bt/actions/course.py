"""Where a peer is headed: so far ahead the turn rate of a moment tells nothing."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from ..control.drive import Array
from ..geometry import Pose2, Twist2

SPAN = 1.0
"""Over so long its course is taken [s]."""

WATCHED = 0.3
"""For so long it must have been watched for that, without a gap of as much [s]."""


class Course:
    """Where a peer is headed: as it went in the last while, straight on."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, Pose2]] = deque()

    def note(self, t: float, pose: Pose2) -> None:
        """Where it is now [s]; a gap in what is known of it makes it begin anew."""
        if self._seen and t - self._seen[-1][0] > WATCHED:
            self._seen.clear()
        self._seen.append((t, pose))
        while t - self._seen[0][0] > SPAN + 1e-9:
            self._seen.popleft()

    def ahead(self, twist: Twist2, times: Array) -> Array:
        """(n, 3) Where it will be after some times [s]; by its twist, until it has been watched for long enough."""
        (begun, first), (t, here) = self._seen[0], self._seen[-1]
        watched = t - begun
        vx, vy = twist.forward * math.cos(here.yaw), twist.forward * math.sin(here.yaw)
        if watched >= WATCHED - 1e-9:
            vx, vy = (here.x - first.x) / watched, (here.y - first.y) / watched
        return np.stack([here.x + vx * times, here.y + vy * times, np.full_like(times, here.yaw)], axis=1)
