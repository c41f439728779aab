"""Odometer: pose of a simulated robot by dead reckoning, which its pose sensors can read instead of ground truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...base.geometry import Pose2, Twist2, along_arc, wrap_angle
from ...control.locomotion import Array, Locomotion

if TYPE_CHECKING:
    from .world import MujocoWorld


class Odometer:
    """Dead reckoning from the pose at the first reading; it is never corrected.

    The way is that of the wheels' shafts, which turn while the wheels slip, too. On a body without wheels it is that of
    the base. It is wrong by a share that is sampled once, as by a wrong wheel radius. The yaw is that of a gyro: of the
    base, with an error that grows as a random walk.

    Args:
        world: World of the robot.
        robot: Name of the robot.
        share: Standard deviation of the relative error of the way, and of the change of the yaw's error in a second
            [rad].
        rng: Random generator of the errors.
        travel: Function that returns the travel of each wheel since the start [m]; None without wheels.
        locomotion: Locomotion of the robot, with its wheels in this order.
    """

    def __init__(
        self,
        world: MujocoWorld,
        robot: str,
        share: float,
        rng: np.random.Generator,
        travel: Callable[[], Sequence[float]] | None,
        locomotion: Locomotion,
    ) -> None:
        self._world, self._robot, self._share, self._rng = world, robot, share, rng
        self._travel, self._locomotion = travel, locomotion
        self._scale = 1.0 + share * float(rng.standard_normal())
        self._last: tuple[float, Pose2, Array] | None = None  # time, true pose, travel at the last call
        self._pose = Pose2(math.nan, math.nan, math.nan)

    def pose(self) -> Pose2:
        """Pose at the present state of the world, world frame."""
        stamp, true = self._world.stamp, self._world.pose(self._robot)
        travel = np.array(self._travel() if self._travel else ())
        if self._last is None:
            self._pose = true
        elif stamp != self._last[0]:
            turn = wrap_angle(true.yaw - self._last[1].yaw)
            forward, left = self._way(self._last[1], turn, true, travel - self._last[2])
            turn += self._share * math.sqrt(stamp - self._last[0]) * float(self._rng.standard_normal())
            self._pose = along_arc(self._pose, Twist2(self._scale * forward, turn, self._scale * left), 1.0)
        self._last = stamp, true, travel
        return self._pose

    def _way(self, before: Pose2, turn: float, true: Pose2, travel: Array) -> tuple[float, float]:
        """Way of the base since the last call, forward and left [m]."""
        if self._travel:
            twist = self._locomotion.twist(travel)
            return twist.forward, twist.left
        c, s = math.cos(before.yaw + 0.5 * turn), math.sin(before.yaw + 0.5 * turn)
        dx, dy = true.x - before.x, true.y - before.y
        return c * dx + s * dy, c * dy - s * dx
