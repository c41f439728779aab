"""Trail: the poses that a robot has passed, which are ground that it has driven over."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import numpy.typing as npt

from ..base.geometry import Pose2
from .footprint import Footprint
from .locomotion import Array

SPACING = 0.04
"""Distance from the last stored pose from which on the next one is stored [m]."""

TURNED = 0.1
"""Turn from the last stored pose from which on the next one is stored [rad]."""

LENGTH = 500
"""Number of stored poses; the oldest are forgotten."""


class Trail:
    """Poses that a robot has passed, world frame, newest last."""

    def __init__(self) -> None:
        self._poses: deque[Pose2] = deque(maxlen=LENGTH)

    def add(self, pose: Pose2) -> None:
        """Store the present pose, unless it is unknown or near the last stored one."""
        if math.isnan(pose.x + pose.y + pose.yaw):
            return
        last = self._poses[-1] if self._poses else None
        turn = math.inf if last is None else abs(math.remainder(pose.yaw - last.yaw, math.tau))
        if last is None or turn > TURNED or pose.distance(last) > SPACING:
            self._poses.append(pose)

    def covers(self, points: Array, footprint: Footprint) -> npt.NDArray[np.bool_]:
        """Whether the hull was over points, world frame, shape (n, 2) [m]; shape (n,), bool."""
        if not self._poses or not len(points):
            return np.zeros(len(points), dtype=bool)
        x, y, yaw = np.array(self._poses).T
        dx, dy, c, s = points[:, :1] - x, points[:, 1:] - y, np.cos(yaw), np.sin(yaw)
        gaps = footprint.gap(c * dx + s * dy, c * dy - s * dx)
        covered: npt.NDArray[np.bool_] = np.asarray((gaps <= SPACING / 4.0).any(axis=1))
        return covered
