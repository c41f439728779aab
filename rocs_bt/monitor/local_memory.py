"""LocalMemory: where echoes came from lately, and where the robot has been; for robots that look to one side only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..geometry import Pose2

Array = npt.NDArray[np.float64]

MOVED = 0.05
"""So far it drives between two looks that are kept [m]."""

TURNED = math.radians(5.0)
"""So far it turns between them [rad]."""

MOST = 300
"""Echoes that it holds; the oldest are forgotten first."""

CLEAR = 0.15
"""An echo so much nearer than a later one in the same direction is gone [m]."""

SPREAD = (-0.6, 0.0, 0.6)
"""Where in its cone an echo may have come from, in half angles: a cone does not say."""


class Mount(NamedTuple):
    """Where a beam begins and looks, in the body frame: [m], [m], [rad]."""

    x: float
    y: float
    yaw: float


@dataclass
class LocalMemory:
    """A short memory of echoes and of the robot's own way, in the frame of its pose.

    What stands still is remembered for a while, so that a robot knows of the wall beside it or behind it which it saw
    before it turned. An echo that a later look finds gone is forgotten at once. Source of the idea: local obstacle
    memories such as VFH's (Borenstein and Koren, The vector field histogram, 1991), with points instead of a grid.

    Args:
        mounts: The beams.
        half_angle: Of each beam's cone [rad].
        reach: As far as they look [m].
        span: How long an echo is remembered [s].
    """

    mounts: Sequence[Mount]
    half_angle: float
    reach: float
    span: float
    _echoes: Array = field(default_factory=lambda: np.empty((0, 3)), init=False)  # x, y [m], time [s]
    _trail: Array = field(default_factory=lambda: np.empty((0, 3)), init=False)  # x, y [m], time [s]
    _last: Pose2 | None = field(default=None, init=False)

    def look(self, t: float, pose: Pose2, ranges: Sequence[float], peers: Sequence[Pose2], radius: float) -> None:
        """Take one reading: what is explained by a peer of that radius [m] is not kept, for it will not stay."""
        last = self._last
        if (
            last is not None
            and pose.distance(last) < MOVED
            and abs(math.remainder(pose.yaw - last.yaw, math.tau)) < TURNED
        ):
            return
        self._last = pose
        self._trail = np.vstack([self._trail[self._trail[:, 2] > t - self.span], (pose.x, pose.y, t)])
        self._echoes = self._echoes[self._echoes[:, 2] > t - self.span]
        for mount, distance in zip(self.mounts, ranges, strict=True):
            if math.isnan(distance):
                continue
            at = pose.compose(Pose2(*mount))
            self._forget(at, min(distance, self.reach))
            if distance < self.reach and not any(self._explains(at, distance, peer, radius) for peer in peers):
                self._keep(at, distance, t)

    def explained(self, pose: Pose2, ranges: Sequence[float], peers: Sequence[Pose2], radius: float) -> list[bool]:
        """Whether each beam's echo is one of a peer of that radius [m]."""
        beams = [(pose.compose(Pose2(*mount)), distance) for mount, distance in zip(self.mounts, ranges, strict=True)]
        return [any(self._explains(at, distance, peer, radius) for peer in peers) for at, distance in beams]

    def around(self, pose: Pose2) -> Array:
        """(k, 2) The echoes that it remembers, in the body frame [m]."""
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        turned: Array = (self._echoes[:, :2] - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])
        return turned

    def been(self, pose: Pose2, within: float) -> bool:
        """Whether the robot was lately so near a place [m]."""
        return bool((np.hypot(self._trail[:, 0] - pose.x, self._trail[:, 1] - pose.y) < within).any())

    def _forget(self, at: Pose2, distance: float) -> None:
        dx, dy = self._echoes[:, 0] - at.x, self._echoes[:, 1] - at.y
        away = np.hypot(dx, dy)
        along = dx * math.cos(at.yaw) + dy * math.sin(at.yaw)
        gone = (away < distance - CLEAR) & (along > math.cos(self.half_angle) * away)
        self._echoes = self._echoes[~gone]

    def _keep(self, at: Pose2, distance: float, t: float) -> None:
        angles = [at.yaw + share * self.half_angle for share in SPREAD]
        found = [(at.x + distance * math.cos(a), at.y + distance * math.sin(a), t) for a in angles]
        self._echoes = np.vstack([self._echoes, found])[-MOST:]

    def _explains(self, at: Pose2, distance: float, peer: Pose2, radius: float) -> bool:
        away = at.distance(peer)
        aside = abs(at.bearing(peer)) - math.asin(min(1.0, radius / max(away, radius)))
        return aside < self.half_angle and away - distance < radius + CLEAR and distance < away + radius
