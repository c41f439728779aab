"""PoseHistory: the recent poses of a robot, to know where it was when a scan was taken."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
from collections.abc import Sequence
from operator import itemgetter

import numpy as np

from ..base.geometry import Pose2, Twist2, wrap_angle
from ..control.footprint import poses_ahead
from ..control.locomotion import Array
from ..interfaces.channel import Signals, Stamped

KEPT = 1.0
"""Age to which poses are stored [s]; no scan that counts is later than that."""


class PoseHistory:
    """The poses of the last `KEPT` seconds, from samples of the signal `pose`."""

    def __init__(self) -> None:
        self._poses: deque[tuple[float, Sequence[float]]] = deque()

    def take(self, samples: Sequence[Stamped[Signals]]) -> None:
        """Store the poses among some samples, oldest first."""
        for sample in samples:
            if "pose" in sample.value:
                self._poses.append((sample.t, sample.value["pose"]))
        while len(self._poses) > 1 and self._poses[-1][0] - self._poses[1][0] >= KEPT - 1e-9:
            self._poses.popleft()

    def at(self, t: float) -> Pose2 | None:
        """Pose at a time [s], world frame, as `along` gives it."""
        if self._poses and self._poses[-1][0] == t:  # most often, scan and pose are of the same moment
            last = Pose2(*self._poses[-1][1])
            return last if all(map(math.isfinite, last)) else None
        found = self.along(np.array([t]))
        if found is None:
            return None
        x, y, yaw = found[0].tolist()
        return Pose2(x, y, wrap_angle(yaw))

    def present(self, now: float, twist: Twist2) -> Pose2 | None:
        """Pose at the present time [s], world frame: the newest one, moved by a twist for its age; None if unknown."""
        pose = self.at(now)
        if pose is None or (age := now - self._poses[-1][0]) <= 0.0:
            return pose
        return pose.compose(Pose2(*poses_ahead(twist, np.array([age]))[0].tolist()))

    def along(self, times: Array) -> Array | None:
        """Poses at some times, interpolated; the first or the last pose outside of what is stored.

        Args:
            times: Times, shape (n,) [s].

        Returns:
            Poses, world frame, shape (n, 3) [m, m, rad], yaw without jumps; None if one of them is unknown.
        """
        if not self._poses:
            return None
        first = bisect_right(self._poses, float(times.min()), key=itemgetter(0)) - 1
        recent = list(self._poses)[max(first, 0) :]
        stamps, poses = np.array([t for t, _ in recent]), np.array([pose for _, pose in recent], float)
        known = np.isfinite(poses[:, 2])
        poses[known, 2] = np.unwrap(poses[known, 2])
        found = np.column_stack([np.interp(times, stamps, poses[:, axis]) for axis in range(3)])
        return found if np.isfinite(found).all() else None
