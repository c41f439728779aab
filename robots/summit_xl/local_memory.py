"""Short memory of echoes and of free ground, for a robot with beams to one side only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rocs_bt import Pose2

from .free_ground import FreeGround

Array = npt.NDArray[np.float64]

MOVED = 0.05
"""Distance after which the next reading is stored [m]."""

TURNED = math.radians(5.0)
"""Turn after which the next reading is stored [rad]."""

AGAIN = 1.0
"""Time after which a reading is stored even if the robot is stationary, so that visible things are kept [s]."""

MOST = 1000
"""Largest number of stored echoes; the oldest are dropped first."""

CLEAR = 0.15
"""Distance by which a later range in the direction of an echo must be longer to delete the echo [m]."""

SPREAD = (-0.6, 0.0, 0.6)
"""Directions at which an echo is stored, as multiples of the cone's half angle; the true one is unknown."""

UNDER = 0.15
"""Half the side of a square that the hull of any peer covers [m]."""


class Mount(NamedTuple):
    """Origin [m] and direction [rad] of a beam in the body frame."""

    x: float
    y: float
    yaw: float


@dataclass
class LocalMemory:
    """Short memory of echoes and of free ground, in the frame of the robot's pose.

    Echoes of stationary things are stored for a while, so the robot still knows a wall beside or behind it after a
    turn. An echo is deleted as soon as a later reading shows that it is gone. Ground is free where a beam passed and
    where the robot or a peer was. The idea is that of local obstacle memories such as the histogram grid of VFH
    (Borenstein and Koren, The vector field histogram, 1991), with points instead of cells for obstacles.

    Args:
        mounts: Mounts of the beams.
        half_angle: Half the opening angle of a beam's cone [rad].
        max_range: Maximum range of the beams [m].
        span: Time for which an echo is stored [s].
        half: Half the hull's length and width [m].
    """

    mounts: Sequence[Mount]
    half_angle: float
    max_range: float
    span: float
    half: tuple[float, float]
    _echoes: Array = field(default_factory=lambda: np.empty((0, 3)), init=False)  # x, y [m], time [s]
    _ground: FreeGround = field(default_factory=FreeGround, init=False)
    _last: Pose2 | None = field(default=None, init=False)
    _looked: float = field(default=-math.inf, init=False)

    def __post_init__(self) -> None:
        self._hull = _filled(*self.half)
        self._under = _filled(UNDER, UNDER)
        radius = math.hypot(*self.half)
        disc = _filled(radius, radius)
        self._disc = disc[np.hypot(disc[:, 0], disc[:, 1]) <= radius][None, None]  # a path of one stride
        square = _filled(self.max_range, self.max_range)
        away = np.hypot(square[:, 0], square[:, 1])
        inside = (away < self.max_range) & (square[:, 0] >= math.cos(self.half_angle) * away)
        self._cone, self._away = square[inside], away[inside]
        angles = np.linspace(-self.half_angle, self.half_angle, 7)
        self._rim = np.stack([np.cos(angles), np.sin(angles)], axis=1)

    @property
    def cell(self) -> float:
        """Side of a square of the map of free ground [m]."""
        return self._ground.cell

    def look(self, t: float, pose: Pose2, ranges: Sequence[float], peers: Sequence[Pose2], radius: float) -> None:
        """Store one reading of all beams, without echoes of peers, since peers move on.

        Args:
            t: Time of the reading [s].
            pose: Pose of the robot.
            ranges: Range of each beam [m].
            peers: Poses of the known peers.
            radius: Radius of a peer's hull [m].
        """
        last = self._last
        if (
            last is not None
            and t - self._looked < AGAIN
            and pose.distance(last) < MOVED
            and abs(math.remainder(pose.yaw - last.yaw, math.tau)) < TURNED
        ):
            return
        self._last, self._looked = pose, t
        self._echoes = self._echoes[self._echoes[:, 2] > t - self.span]
        self._ground.centre(pose)
        self._ground.mark(pose, self._hull, t)
        for peer in peers:
            self._ground.mark(peer, self._under, t)
        for mount, distance in zip(self.mounts, ranges, strict=True):
            if math.isnan(distance):
                continue
            at = pose.compose(Pose2(*mount))
            self._forget(at, min(distance, self.max_range))
            self._ground.mark(at, self._cone[self._away < distance - CLEAR], t)
            if distance < self.max_range and not any(self._explains(at, distance, peer, radius) for peer in peers):
                self._keep(at, distance, t)

    def explained(self, pose: Pose2, ranges: Sequence[float], peers: Sequence[Pose2], radius: float) -> list[bool]:
        """Whether the echo of each beam can come from a known peer with a hull of this radius [m]."""
        found = []
        for mount, distance in zip(self.mounts, ranges, strict=True):
            at = pose.compose(Pose2(*mount)) if math.isfinite(distance) else None
            found.append(at is not None and any(self._explains(at, distance, peer, radius) for peer in peers))
        return found

    def around(self, pose: Pose2, since: float) -> Array:
        """Positions of the echoes since a time [s], body frame [m], shape (k, 2)."""
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        echoes = self._echoes[self._echoes[:, 2] > since]
        turned: Array = (echoes[:, :2] - (pose.x, pose.y)).dot(np.array([[c, -s], [s, c]]))
        return turned

    def strides(self, since: float, pose: Pose2, paths: Array) -> list[int]:
        """Number of strides of each path on ground seen free since a time [s]; see `FreeGround.strides`."""
        return self._ground.strides(pose, paths, since)

    def may_turn(self, since: float, pose: Pose2) -> bool:
        """Whether all ground that the hull sweeps in a turn on the spot was seen free since a time [s]."""
        return self._ground.strides(pose, self._disc, since) == [1]

    def _forget(self, at: Pose2, distance: float) -> None:
        """Delete the echoes that a beam at a pose has passed, because it measured a longer distance [m]."""
        dx, dy = self._echoes[:, 0] - at.x, self._echoes[:, 1] - at.y
        away = np.hypot(dx, dy)
        along = dx * math.cos(at.yaw) + dy * math.sin(at.yaw)
        gone = (away < distance - CLEAR) & (along > math.cos(self.half_angle) * away)
        self._echoes = self._echoes[~gone]

    def _keep(self, at: Pose2, distance: float, t: float) -> None:
        """Store the echo of a beam at a pose and a distance [m], and mark the ground there as not free."""
        angles = [at.yaw + share * self.half_angle for share in SPREAD]
        found = [(at.x + distance * math.cos(a), at.y + distance * math.sin(a), t) for a in angles]
        self._echoes = np.vstack([self._echoes, found])[-MOST:]
        edge = 0.5 * self._ground.cell
        rim = np.vstack([self._rim * (distance - edge), self._rim * (distance + edge)])
        self._ground.mark(at, rim, -math.inf)

    def _explains(self, at: Pose2, distance: float, peer: Pose2, radius: float) -> bool:
        """Whether the echo of a beam at a pose and a distance [m] can come from a peer's hull of a radius [m]."""
        away = at.distance(peer)
        aside = abs(at.bearing(peer)) - math.asin(min(1.0, radius / max(away, radius)))
        return aside < self.half_angle and away - distance < radius + CLEAR and distance < away + radius


def _filled(length: float, width: float, spacing: float = 0.07) -> Array:
    """Points that fill a rectangle about the origin, of half a length and half a width [m], shape (k, 2)."""
    along = np.linspace(-length, length, math.ceil(2.0 * length / spacing) + 1)
    aside = np.linspace(-width, width, math.ceil(2.0 * width / spacing) + 1)
    return np.stack(np.meshgrid(along, aside), axis=-1).reshape(-1, 2)
