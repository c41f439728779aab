"""Reading the robot's pose as a moving action must: it may be lost for a moment, and not for long."""

from __future__ import annotations

import math

from ..action import ActionFailed, Body, Reason
from ..geometry import Pose2

PATIENCE = 5
"""For how many periods in a row an action stands still and waits for a pose before it fails with LOST_POSE."""


class PoseWatch:
    """The pose, period by period. One watch belongs to one action."""

    def __init__(self) -> None:
        self._lost = 0

    def look(self, body: Body) -> Pose2 | None:
        """The robot's pose in the world frame; None while it is lost, in which the robot must stand.

        Raises:
            ActionFailed: LOST_POSE, once it has been lost for longer than `PATIENCE` periods.
        """
        pose = body.knowledge.robot.pose(body.clock.now())
        if all(map(math.isfinite, pose)):
            self._lost = 0
            return pose
        self._lost += 1
        if self._lost > PATIENCE:
            seconds = self._lost * body.period
            raise ActionFailed(Reason.LOST_POSE, f"the signal 'pose' has been invalid for {seconds:.2f} s")
        return None
