"""Where a robot that follows goes: after its leader as on a string, or out of somebody's way."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from ..control.drive import Array
from ..control.ways import BENDS, sinc
from ..geometry import Pose2

SPEEDS = (1.0, 0.6, 0.3)
"""Of the cruise speed: how fast the ways go."""

KEEP = 0.6
"""What to leave between the hull and the middle of another robot [m]."""

LEVER = 4.0
"""How much a metre too near to somebody counts, beside the square of the metres too far from the leader."""

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
    x, y, yaw = pose
    flat = [x, y, yaw]
    crowds = list(zip(*(other[1:, :2].tolist() for other in others), strict=True)) or [()] * (len(leader) - 1)
    for (place_x, place_y, _), crowd in zip(leader[1:].tolist(), crowds, strict=True):
        away = math.hypot(place_x - x, place_y - y)
        if away > length:
            step, heading = min(away - length, stride), math.atan2(place_y - y, place_x - x)
            for detour in DETOURS:
                angle = heading + detour
                c, s = math.cos(angle), math.sin(angle)
                if _clear(x, y, x + LOOK * c, y + LOOK * s, crowd, keep_off):
                    x, y, yaw = x + step * c, y + step * s, angle
                    break
        flat += (x, y, yaw)
    return np.array(flat).reshape(-1, 3)


def _clear(x: float, y: float, to_x: float, to_y: float, crowd: Iterable[Sequence[float]], keep_off: float) -> bool:
    """Whether a step comes not too near to anybody, or at least no nearer."""
    for at_x, at_y in crowd:
        apart = math.hypot(to_x - at_x, to_y - at_y)
        if not (apart >= keep_off or apart >= math.hypot(x - at_x, y - at_y)):
            return False
    return True


def _nearest(way: Array, other: Array) -> float:
    """How near two ways (k, 3) come, each moment with its own [m]."""
    return float(np.hypot(way[:, 0] - other[:, 0], way[:, 1] - other[:, 1]).min())


class GiveWay:
    """The best of some ways, when the string's would come too near to somebody: arcs ahead and back, and standing.

    A way is judged by how near it comes to the others' predicted places, and how far it is from the leader's. It goes
    over free ground only, and not within the string's length of the leader, or not nearer than standing would: who
    gives way to its leader, or into its corner, holds up both. Source of the idea: Fox,
    Burgard and Thrun, The dynamic window approach to collision avoidance (1997), with the others' motion.

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
        self._last = 0

    def needed(self, way: Array, leader: Array, others: Sequence[Array]) -> bool:
        """Whether a way (k, 3) comes too near to somebody."""
        if _nearest(way, leader) < self._room:
            return True
        far = KEEP + math.hypot(*self._half)  # the gap is no less than the distance without half the diagonal
        return any(
            _nearest(way, other) < far and float(self._gap(way[:, 0], way[:, 1], way[:, 2], other).min()) < KEEP
            for other in others
        )

    def best(self, pose: Pose2, leader: Array, others: Sequence[Array], ahead: Array, behind: Array) -> Array:
        """(k, 3) The way to go.

        Args:
            pose: Where the robot is.
            leader: (k, 3) Where the leader will be.
            others: (k, 3) each, where the others will be.
            ahead: (n,) How far it may drive on each bend [m].
            behind: (n,) How far back [m].
        """
        reach = np.concatenate([[0.0], *[ahead] * len(SPEEDS), *[behind] * len(SPEEDS)])[:, None]
        run = self._signs * np.minimum(self._runs, reach)  # (n, k)
        turned = self._bends * run
        half = 0.5 * turned
        chord = run * sinc(half / math.pi)
        x, y = pose.x + chord * np.cos(pose.yaw + half), pose.y + chord * np.sin(pose.yaw + half)
        yaw = pose.yaw + turned
        far = np.hypot(x - leader[:, 0], y - leader[:, 1])
        cost = np.square(np.maximum(far - self._length, 0.0)).mean(axis=1)  # a little too far does no harm
        cost += LEVER * np.maximum(self._room - far, 0.0).mean(axis=1)
        for other in others:
            short = np.maximum(KEEP - self._gap(x, y, yaw, other), 0.0)
            cost += LEVER * (short.mean(axis=1) + short.max(axis=1))
        cost[far.min(axis=1) < min(self._length, far[0].min() - 0.02)] = math.inf
        cost[self._last] -= STICK
        self._last = int(cost.argmin())
        return np.array([x[self._last], y[self._last], yaw[self._last]]).T

    def _gap(self, x: Array, y: Array, yaw: Array, other: Array) -> Array:
        """(..., k) Between the hull on a way and the middle of another robot [m]."""
        c, s = np.cos(yaw), np.sin(yaw)
        dx, dy = other[:, 0] - x, other[:, 1] - y
        ahead, aside = np.abs(c * dx + s * dy) - self._half[0], np.abs(c * dy - s * dx) - self._half[1]
        gap: Array = np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0))
        return gap
