"""Where a robot that follows goes: after its leader as on a string, or out of somebody's way."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..control.arcs import BENDS, HEADINGS, sinc
from ..control.drive import Array
from ..control.reference import TURN_RATE
from ..geometry import Pose2
from .room import Room

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

NEARER = 0.02
"""By so much a way may lead nearer to the leader than standing would [m]."""

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
    way = [(x, y, yaw)]
    crowds = list(zip(*(other[1:, :2].tolist() for other in others), strict=True)) or [()] * (len(leader) - 1)
    for (place_x, place_y, _), crowd in zip(leader[1:].tolist(), crowds, strict=True):
        away = math.hypot(place_x - x, place_y - y)
        if away > length:
            step, heading = min(away - length, stride), math.atan2(place_y - y, place_x - x)
            for detour in DETOURS:
                angle = heading + detour
                c, s = math.cos(angle), math.sin(angle)
                for at_x, at_y in crowd:
                    apart = math.hypot(x + LOOK * c - at_x, y + LOOK * s - at_y)
                    if not (apart >= keep_off or apart >= math.hypot(x - at_x, y - at_y)):
                        break  # too near to another robot, and nearer than now
                else:
                    x, y, yaw = x + step * c, y + step * s, angle
                    break
        way.append((x, y, yaw))
    return np.array(way)


def nearest_moment(way: Array, other: Array) -> float:
    """How near two ways (k, 3) come, each moment with its own [m]."""
    return float(np.hypot(way[:, 0] - other[:, 0], way[:, 1] - other[:, 1]).min())


def braked(speed: Array | float, reach: Array, times: Array, braking: float) -> Array:
    """How far one has gone at some times [s], at a speed [m/s] from which one brakes [m/s2] to stand at a reach [m]."""
    fast = np.minimum(speed, np.sqrt(2.0 * braking * reach))
    cruised = np.maximum((reach - fast * fast / (2.0 * braking)) / np.maximum(fast, 1e-9), 0.0)
    slowed = np.minimum(np.maximum(times - cruised, 0.0), fast / braking)
    gone: Array = fast * np.minimum(times, cruised) + (fast - 0.5 * braking * slowed) * slowed
    return gone


def least_apart(way: Array, other: Array, half: tuple[float, float]) -> float:
    """The least gap [m] between a hull on its way (k, 3), half so long and wide, and the middle of another (k, 3)."""
    return float(_apart(way.T[:, None], other, half).min())


def _apart(ways: Array, other: Array, half: tuple[float, float]) -> Array:
    """(n, k) Gaps between the hull on ways (3, n, k) and the middle of another robot [m]."""
    x, y, yaw = ways
    c, s = np.cos(yaw), np.sin(yaw)
    dx, dy = other[:, 0] - x, other[:, 1] - y
    ahead, aside = np.abs(c * dx + s * dy) - half[0], np.abs(c * dy - s * dx) - half[1]
    gaps: Array = np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0))
    return gaps


class GiveWay:
    """The best of some ways, when the string's would come too near to somebody.

    They are arcs ahead and back, a turn on the spot and then straight on, with the nose or the stern ahead, and
    standing. A way is judged by how near it comes to the others' predicted places, and how far it is from the leader's.
    It goes over free ground only, braking in time, and not within the string's length of the leader, or never nearer
    than standing would have been by then: who gives way to its leader, or into its corner, holds up both. Who cannot
    stay where it is may come as near to its leader as `room`. The leader is looked at for longer than a way is: who
    backs off before one that comes has no more free ground behind it then, and is in the way where it should have gone
    aside. Source of the idea: Fox, Burgard and Thrun, The dynamic window approach to collision avoidance (1997), with
    the others' motion.

    Args:
        length: Of the string [m].
        room: What to leave to the leader [m].
        half: Half the hull's length and width [m].
        speed: Fastest [m/s].
        braking: How hard it brakes where its free ground ends [m/s2].
        times: (k,) At which the ways are asked for, from 0 on [s].
        afar: (n,) At which it looks at its leader: the same, and more of them [s].

    Attributes:
        keep_off: A place so far from another robot leaves it enough, however this one is turned [m].
    """

    def __init__(
        self,
        *,
        length: float,
        room: float,
        half: tuple[float, float],
        speed: float,
        braking: float,
        times: Array,
        afar: Array,
    ) -> None:
        self.times, self.afar = times, afar
        self.keep_off = KEEP + half[0]
        self._length, self._room, self._half = length, room, half
        ways = [(sign * share * speed, bend) for sign in (1.0, -1.0) for share in SPEEDS for bend in BENDS]
        speeds, self._bends = np.array(list(zip((0.0, 0.0), *ways, strict=True)))[:, :, None]  # (n, 1) [m/s], [rad/m]
        self._signs, self._speeds, self._braking = np.sign(speeds), np.abs(speeds), braking
        self._speed = speed
        self._last = 0

    def needed(self, way: Array, leader: Array, others: Sequence[Array]) -> bool:
        """Whether a way (k, 3) comes too near to somebody."""
        if nearest_moment(way, leader) < self._room:
            return True
        far = KEEP + math.hypot(*self._half)  # the gap is no less than the distance without half the diagonal
        return any(nearest_moment(way, other) < far and least_apart(way, other, self._half) < KEEP for other in others)

    def best(self, pose: Pose2, leader: Array, others: Sequence[Array], room: Room) -> Array:
        """(k, 3) The way to go.

        Args:
            pose: Where the robot is.
            leader: (n, 3) Where the leader will be, at the times `afar`.
            others: (k, 3) each, where the others will be.
            room: How far it may drive.
        """
        ways = np.concatenate([self._arcs(pose, room), self._turns(pose, room)], axis=1)
        cost = self._costs(ways, leader, others)
        cost[len(self._bends) :][room.turned <= 0.0] = math.inf
        cost[self._last] -= STICK
        self._last = int(cost.argmin())
        return ways[:, self._last, : len(self.times)].T

    def _arcs(self, pose: Pose2, room: Room) -> Array:
        """Positions and yaws (3, n, k) when standing, then on each arc ahead and each back, at the times `afar`."""
        runs = self._runs_within(room)
        turned = self._bends * runs
        half = 0.5 * turned
        chord, middle = runs * sinc(half / math.pi), pose.yaw + half
        return np.stack([pose.x + chord * np.cos(middle), pose.y + chord * np.sin(middle), pose.yaw + turned])

    def _turns(self, pose: Pose2, room: Room) -> Array:
        """Positions and yaws (3, m, k) of a turn on the spot to each heading, then straight on, at the times `afar`."""
        off = HEADINGS - pose.yaw
        errors = np.arctan2(np.sin(off), np.cos(off))
        errors -= np.where(np.abs(errors) > 0.5 * math.pi, np.copysign(math.pi, errors), 0.0)  # the stern is nearer
        took = np.abs(errors) / TURN_RATE
        took = (took + np.minimum(took, TURN_LAG))[:, None]
        driving = np.maximum(self.afar - took, 0.0)
        runs = braked(SPEEDS[1] * self._speed, room.turned[:, None], driving, self._braking)
        return np.stack(
            [
                pose.x + runs * np.cos(HEADINGS)[:, None],
                pose.y + runs * np.sin(HEADINGS)[:, None],
                pose.yaw + errors[:, None] * np.minimum(self.afar / np.maximum(took, 1e-6), 1.0),
            ]
        )

    def _costs(self, ways: Array, leader: Array, others: Sequence[Array]) -> Array:
        """Costs (n,) of ways (3, n, k), the first of which is standing; infinite where too near to the leader.

        A cost is the square of the metres too far from the leader, and `LEVER` for each metre too near to a robot.
        """
        soon = len(self.times)
        far = np.hypot(ways[0] - leader[:, 0], ways[1] - leader[:, 1])
        costs: Array = np.square(np.maximum(far[:, :soon] - self._length, 0.0)).sum(axis=1) / soon
        costs += LEVER * (np.maximum(self._room - far, 0.0).sum(axis=1) / ways.shape[2])
        limit = self._length
        for other in others:
            short = np.maximum(KEEP - _apart(ways[:, :, :soon], other, self._half), 0.0)
            costs += LEVER * (short.sum(axis=1) / soon + short.max(axis=1))
            if short[0].any():  # it cannot stay
                limit = self._room
        costs[(far < np.minimum(limit, np.minimum.accumulate(far[0]) - NEARER)).any(axis=1)] = math.inf
        return costs

    def _runs_within(self, room: Room) -> Array:
        """(n, k) How far standing leads, then each arc ahead and each back [m]."""
        reach = np.concatenate([[0.0], *[room.ahead] * len(SPEEDS), *[room.behind] * len(SPEEDS)])[:, None]
        runs: Array = self._signs * braked(self._speeds, reach, self.afar, self._braking)
        return runs
