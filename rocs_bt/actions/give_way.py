"""Where a robot that follows goes: after its leader as on a string, or out of somebody's way."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ..compiled import compiled
from ..control.drive import Array
from ..control.reference import TURN_RATE
from ..control.ways import BENDS, HEADINGS, sinc
from ..geometry import Pose2

SPEEDS = (1.0, 0.6, 0.3)
"""Of the cruise speed: how fast the ways go."""

KEEP = 0.6
"""What to leave between the hull and the middle of another robot [m]."""

LEVER = 4.0
"""How much a metre too near to somebody counts, beside the square of the metres too far from the leader."""

TURN_LAG = 0.3
"""Time lost while it begins to turn on the spot, and while it ends [s]."""

STICK = 0.02
"""By so much another way must be better than the one that it is on [m]."""


DETOURS = [math.radians(sign * angle) for angle in (0.0, 20.0, 40.0, 60.0, 80.0) for sign in (1.0, -1.0)][1:]
"""By how much a string is bent round who is in the way, the least first [rad]."""

LOOK = 0.3
"""So far ahead of each step nobody may be [m]."""


def pulled(
    pose: Pose2, leader: Array, length: float, stride: float, others: Sequence[Array] = (), keep_off: float = KEEP
) -> Array:
    """(k, 3) Where a string takes the robot while its leader passes some poses: as a trailer goes, or round somebody.

    Args:
        pose: Where the robot is.
        leader: (k, 3) The leader's poses, the first of them now.
        length: Of the string [m].
        stride: The longest step between two of the poses [m].
        others: (k, 3) each, round whom it is bent.
        keep_off: As far as that [m].
    """
    way = np.empty(leader.shape)
    pull(way, pose, leader, others, DETOURS, (length, stride, keep_off, LOOK))
    return way


@compiled
def pull(
    way: Array,
    pose: Pose2,
    leader: Array,
    others: Sequence[Array],
    detours: Sequence[float],
    limits: tuple[float, float, float, float],
) -> None:
    """Fill a way (k, 3) as `pulled` says, with the string's length, stride, keep_off and how far to look ahead [m]."""
    (x, y, yaw), (length, stride, keep_off, look) = pose, limits
    way[0] = pose
    crowds = list(zip(*(other[1:, :2].tolist() for other in others), strict=True)) or [()] * (len(leader) - 1)
    for k, ((place_x, place_y, _), crowd) in enumerate(zip(leader[1:].tolist(), crowds, strict=True), 1):
        away = math.hypot(place_x - x, place_y - y)
        if away > length:
            step, heading = min(away - length, stride), math.atan2(place_y - y, place_x - x)
            for detour in detours:
                angle = heading + detour
                c, s = math.cos(angle), math.sin(angle)
                if _clear(x, y, x + look * c, y + look * s, crowd, keep_off):
                    x, y, yaw = x + step * c, y + step * s, angle
                    break
        way[k] = x, y, yaw


def _clear(x: float, y: float, to_x: float, to_y: float, crowd: Iterable[Sequence[float]], keep_off: float) -> bool:
    """Whether a step comes not too near to anybody, or at least no nearer."""
    for at_x, at_y in crowd:
        apart = math.hypot(to_x - at_x, to_y - at_y)
        if not (apart >= keep_off or apart >= math.hypot(x - at_x, y - at_y)):
            return False
    return True


@compiled
def nearest_moment(way: Array, other: Array) -> float:
    """How near two ways (k, 3) come, each moment with its own [m]."""
    return float(np.hypot(way[:, 0] - other[:, 0], way[:, 1] - other[:, 1]).min())


class Room(NamedTuple):
    """How far a robot may drive on ground that it knows to be free [m]; nowhere where nobody knows."""

    ahead: Array  # (n,) on each of `control.ways.BENDS`
    behind: Array  # (n,) back on each of them
    turned: Array  # (m,) ahead, once turned on the spot to each of `control.ways.HEADINGS`

    @classmethod
    def none(cls) -> Room:
        """Where nobody knows."""
        return cls(np.zeros(len(BENDS)), np.zeros(len(BENDS)), np.zeros(len(HEADINGS)))


class GiveWay:
    """The best of some ways, when the string's would come too near to somebody.

    They are arcs ahead and back, a turn on the spot and then straight ahead, and standing. A way is judged by how near
    it comes to the others' predicted places, and how far it is from the leader's. It goes over free ground only, and
    not within the string's length of the leader, or not nearer than standing would: who gives way to its leader, or
    into its corner, holds up both. Who cannot stay where it is may come as near to its leader as `room`. Source of the
    idea: Fox, Burgard and Thrun, The dynamic window approach to collision avoidance (1997), with the others' motion.

    Args:
        length: Of the string [m].
        room: What to leave to the leader [m].
        half: Half the hull's length and width [m].
        speed: Fastest [m/s].
        times: (k,) At which the ways are asked for, from 0 on [s].

    Attributes:
        keep_off: A place so far from another robot leaves it enough, however this one is turned [m].
    """

    def __init__(self, *, length: float, room: float, half: tuple[float, float], speed: float, times: Array) -> None:
        self.times = times
        self.keep_off = KEEP + half[0]
        self._length, self._room, self._half = length, room, half
        ways = [(sign * share * speed, bend) for sign in (1.0, -1.0) for share in SPEEDS for bend in BENDS]
        speeds, self._bends = np.array([(0.0, 0.0), *ways]).T[:, :, None]  # (n, 1) [m/s], [rad/m]
        self._signs, self._runs = np.sign(speeds), np.abs(speeds) * times  # (n, 1), and (n, k) [m]
        self._turned_speed = SPEEDS[1] * speed  # [m/s]
        self._last = 0

    def needed(self, way: Array, leader: Array, others: Sequence[Array]) -> bool:
        """Whether a way (k, 3) comes too near to somebody."""
        if nearest_moment(way, leader) < self._room:
            return True
        far = KEEP + math.hypot(*self._half)  # the gap is no less than the distance without half the diagonal
        return any(
            nearest_moment(way, other) < far and float(self._gap(way[:, 0], way[:, 1], way[:, 2], other).min()) < KEEP
            for other in others
        )

    def best(self, pose: Pose2, leader: Array, others: Sequence[Array], room: Room) -> Array:
        """(k, 3) The way to go.

        Args:
            pose: Where the robot is.
            leader: (k, 3) Where the leader will be.
            others: (k, 3) each, where the others will be.
            room: How far it may drive.
        """
        x, y, yaw = np.concatenate([self._arcs(pose, room), self._turns(pose, room)], axis=1)
        barred = np.concatenate([np.zeros(len(self._bends), bool), room.turned <= 0.0])
        far = np.hypot(x - leader[:, 0], y - leader[:, 1])
        cost = np.square(np.maximum(far - self._length, 0.0)).mean(axis=1)  # a little too far does no harm
        cost += LEVER * np.maximum(self._room - far, 0.0).mean(axis=1)
        limit = self._length
        for other in others:
            short = np.maximum(KEEP - self._gap(x, y, yaw, other), 0.0)
            cost += LEVER * (short.mean(axis=1) + short.max(axis=1))
            if short[0].any():  # it cannot stay
                limit = self._room
        cost[barred | (far.min(axis=1) < min(limit, far[0].min() - 0.02))] = math.inf
        cost[self._last] -= STICK
        self._last = int(cost.argmin())
        return np.array([x[self._last], y[self._last], yaw[self._last]]).T

    def _arcs(self, pose: Pose2, room: Room) -> Array:
        """(3, n, k) Standing, then the arcs ahead and those back."""
        reach = np.concatenate([[0.0], *[room.ahead] * len(SPEEDS), *[room.behind] * len(SPEEDS)])[:, None]
        run = self._signs * np.minimum(self._runs, reach)
        turned = self._bends * run
        half = 0.5 * turned
        chord, middle = run * sinc(half / math.pi), pose.yaw + half
        return np.stack([pose.x + chord * np.cos(middle), pose.y + chord * np.sin(middle), pose.yaw + turned])

    def _turns(self, pose: Pose2, room: Room) -> Array:
        """(3, m, k) Turning on the spot to each heading, and then straight ahead."""
        error = np.arctan2(np.sin(HEADINGS - pose.yaw), np.cos(HEADINGS - pose.yaw))[:, None]
        turning = np.abs(error) / TURN_RATE
        took = turning + np.minimum(turning, TURN_LAG)
        run = np.clip(self._turned_speed * (self.times - took), 0.0, room.turned[:, None])
        yaw = pose.yaw + error * np.minimum(self.times / np.maximum(took, 1e-6), 1.0)
        heading = HEADINGS[:, None]
        return np.stack([pose.x + run * np.cos(heading), pose.y + run * np.sin(heading), yaw])

    def _gap(self, x: Array, y: Array, yaw: Array, other: Array) -> Array:
        """(..., k) Between the hull on a way and the middle of another robot [m]."""
        c, s = np.cos(yaw), np.sin(yaw)
        dx, dy = other[:, 0] - x, other[:, 1] - y
        ahead, aside = np.abs(c * dx + s * dy) - self._half[0], np.abs(c * dy - s * dx) - self._half[1]
        gap: Array = np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0))
        return gap
