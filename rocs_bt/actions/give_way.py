"""Local planning of FollowRobot: the path of a trailer behind its leader, or a path that gives way."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..base.geometry import Pose2
from ..control.arcs import BENDS, HEADINGS, sinc
from ..control.locomotion import Array
from ..control.reference import TURN_RATE
from .room import Room

SPEEDS = (1.0, 0.6, 0.3)
"""Speeds of the candidates, as shares of the cruise speed."""

KEEP = 0.6
"""Gap to keep between the hull and the centre of another robot [m]."""

LEVER = 4.0
"""Weight of the cost term for nearness to other robots [m], relative to that for distance from the leader [m2]."""

TURN_LAG = 0.3
"""Time that a turn on the spot loses by acceleration and braking [s]."""

STICK = 0.02
"""Cost advantage of the candidate of the last period, which prevents alternation between two candidates [m2]."""

NEARER = 0.02
"""Distance by which a candidate may come nearer to the leader than a standstill would [m]."""

DETOURS = [math.radians(sign * angle) for angle in (0.0, 20.0, 40.0, 60.0, 80.0) for sign in (1.0, -1.0)][1:]
"""Changes of direction that are tried to pass other robots, the smallest first [rad]."""

LOOK = 0.3
"""Distance ahead of each step at which the distance to other robots is checked [m]."""


def trailer_path(
    pose: Pose2, leader: Array, length: float, stride: float, others: Sequence[Array] = (), keep_off: float = KEEP
) -> Array:
    """Path of a trailer on a rope behind its leader (a tractrix), with detours around other robots.

    Args:
        pose: Pose of the robot, world frame.
        leader: Poses of the leader, the first of them now, shape (k, 3) [m, m, rad].
        length: Length of the rope [m].
        stride: Maximum step between two poses [m].
        others: Poses of each other robot, shape (k, 3).
        keep_off: Distance to keep from the other robots [m].

    Returns:
        Poses of the robot, world frame, shape (k, 3) [m, m, rad].
    """
    x, y, yaw = pose
    path = [(x, y, yaw)]
    crowds = list(zip(*(other[1:, :2].tolist() for other in others), strict=True)) or [()] * (len(leader) - 1)
    for (leader_x, leader_y, _), crowd in zip(leader[1:].tolist(), crowds, strict=True):
        away = math.hypot(leader_x - x, leader_y - y)
        if away > length:
            step, heading = min(away - length, stride), math.atan2(leader_y - y, leader_x - x)
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
        path.append((x, y, yaw))
    return np.array(path)


def min_distance(path: Array, other: Array) -> float:
    """Minimum over time of the distance [m] between two robots; row i of both paths (k, 3) is at the same time."""
    return float(np.hypot(path[:, 0] - other[:, 0], path[:, 1] - other[:, 1]).min())


def braked_distance(speed: Array | float, reach: Array, times: Array, braking: float) -> Array:
    """Distances driven by a robot that brakes so that it stops at a given distance.

    Args:
        speed: Speed before braking [m/s]; it is reduced if `reach` is too short to stop from it.
        reach: Distance at which the robot stops [m].
        times: Times from now [s].
        braking: Deceleration [m/s2].

    Returns:
        Distances at the times [m].
    """
    fast = np.minimum(speed, np.sqrt(2.0 * braking * reach))
    cruised = np.maximum((reach - fast * fast / (2.0 * braking)) / np.maximum(fast, 1e-9), 0.0)
    slowed = np.minimum(np.maximum(times - cruised, 0.0), fast / braking)
    gone: Array = fast * np.minimum(times, cruised) + (fast - 0.5 * braking * slowed) * slowed
    return gone


def min_gap(path: Array, other: Array, half: tuple[float, float]) -> float:
    """Minimum gap between a hull on its path and the centre of another robot on its path.

    Args:
        path: Poses of the hull, shape (k, 3).
        other: Poses of the other robot at the same times, shape (k, 3).
        half: Half the length and half the width of the hull [m].

    Returns:
        Minimum gap [m]; 0 if the centre is inside the hull.
    """
    return float(_gaps(path.T[:, None], other, half).min())


def _gaps(paths: Array, other: Array, half: tuple[float, float]) -> Array:
    """Gaps between the hull on n paths (3, n, k) and the centre of another robot (k, 3), shape (n, k) [m]."""
    x, y, yaw = paths
    c, s = np.cos(yaw), np.sin(yaw)
    dx, dy = other[:, 0] - x, other[:, 1] - y
    ahead, aside = np.abs(c * dx + s * dy) - half[0], np.abs(c * dy - s * dx) - half[1]
    gaps: Array = np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0))
    return gaps


class GiveWay:
    """Choice among candidate paths, used when the trailer path would come too near to another robot.

    Candidates are standstill, arcs ahead and back, and a turn on the spot followed by a straight drive, forward or
    backward. The cost of a candidate grows with its proximity to the predicted positions of other robots and with the
    distance from the leader's. Candidates use only free ground and brake in time.

    A candidate within the follow distance of the leader is excluded, unless it is no nearer than standstill would be: a
    robot that gives way into the path or the corner of its leader blocks both. A robot that cannot stay where it is may
    come as near to its leader as `room`.

    The prediction of the leader is longer than the candidates. Otherwise a robot that backs off from an approaching
    leader runs out of free ground behind it and blocks the leader, although it could have moved aside.

    Source: Fox, Burgard and Thrun, The dynamic window approach to collision avoidance (1997), extended by the motion of
    the other robots.

    Args:
        length: Follow distance [m].
        room: Distance to keep from the leader [m].
        half: Half the length and half the width of the hull [m].
        speed: Maximum speed [m/s].
        braking: Deceleration before the end of the free ground [m/s2].
        times: Times of the returned path, from 0 on, shape (k,) [s].
        leader_times: Times of the leader's prediction: `times` and later ones, shape (n,) [s].

    Attributes:
        keep_off: Distance between the centres of two robots that is safe at any heading of this one [m].
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
        leader_times: Array,
    ) -> None:
        self.times, self.leader_times = times, leader_times
        self.keep_off = KEEP + half[0]
        self._length, self._room, self._half = length, room, half
        arcs = [(sign * share * speed, bend) for sign in (1.0, -1.0) for share in SPEEDS for bend in BENDS]
        speeds, self._bends = np.array(list(zip((0.0, 0.0), *arcs, strict=True)))[:, :, None]  # (n, 1) [m/s], [rad/m]
        self._signs, self._speeds, self._braking = np.sign(speeds), np.abs(speeds), braking
        self._speed = speed
        self._last = 0

    def needed(self, path: Array, leader: Array, others: Sequence[Array]) -> bool:
        """Whether a path (k, 3) comes too near to another robot, so that the robot must give way.

        Args:
            path: Poses of the robot at `times`, shape (k, 3).
            leader: Poses of the leader at the same times, shape (k, 3).
            others: Poses of each other robot at the same times, shape (k, 3).
        """
        if min_distance(path, leader) < self._room:
            return True
        far = KEEP + math.hypot(*self._half)  # beyond this distance the gap is certainly above KEEP
        return any(min_distance(path, other) < far and min_gap(path, other, self._half) < KEEP for other in others)

    def best(self, pose: Pose2, leader: Array, others: Sequence[Array], room: Room) -> Array:
        """Choose the candidate path with the lowest cost.

        Args:
            pose: Pose of the robot, world frame.
            leader: Predicted poses of the leader at `leader_times`, shape (n, 3).
            others: Predicted poses of each other robot at `times`, shape (k, 3).
            room: Free ground around the robot.

        Returns:
            Poses of the robot at `times`, world frame, shape (k, 3).
        """
        candidates = np.concatenate([self._arcs(pose, room), self._turns(pose, room)], axis=1)
        cost = self._costs(candidates, leader, others)
        cost[len(self._bends) :][room.turned <= 0.0] = math.inf
        cost[self._last] -= STICK
        self._last = int(cost.argmin())
        return candidates[:, self._last, : len(self.times)].T

    def _arcs(self, pose: Pose2, room: Room) -> Array:
        """Candidates of standing still or driving an arc: standstill first, then all arcs ahead, then all arcs back.

        Returns:
            x, y and yaw of the n candidates at the k times `leader_times`, world frame, shape (3, n, k) [m, m, rad].
        """
        runs = self._runs_within(room)
        turned = self._bends * runs
        half = 0.5 * turned
        chord, middle = runs * sinc(half / math.pi), pose.yaw + half
        return np.stack([pose.x + chord * np.cos(middle), pose.y + chord * np.sin(middle), pose.yaw + turned])

    def _turns(self, pose: Pose2, room: Room) -> Array:
        """Candidates that turn on the spot to one of the m `HEADINGS`, or to its opposite, and then drive straight.

        Returns:
            x, y and yaw of the m candidates at the k times `leader_times`, world frame, shape (3, m, k) [m, m, rad].
        """
        off = HEADINGS - pose.yaw
        errors = np.arctan2(np.sin(off), np.cos(off))
        errors -= np.where(np.abs(errors) > 0.5 * math.pi, np.copysign(math.pi, errors), 0.0)  # drive backward instead
        took = np.abs(errors) / TURN_RATE
        took = (took + np.minimum(took, TURN_LAG))[:, None]
        driving = np.maximum(self.leader_times - took, 0.0)
        runs = braked_distance(SPEEDS[1] * self._speed, room.turned[:, None], driving, self._braking)
        return np.stack(
            [
                pose.x + runs * np.cos(HEADINGS)[:, None],
                pose.y + runs * np.sin(HEADINGS)[:, None],
                pose.yaw + errors[:, None] * np.minimum(self.leader_times / np.maximum(took, 1e-6), 1.0),
            ]
        )

    def _costs(self, candidates: Array, leader: Array, others: Sequence[Array]) -> Array:
        """Costs (n,) of candidates (3, n, k), the first of which is standstill; infinite if too near to the leader.

        The cost is the squared distance [m2] beyond the follow distance, plus `LEVER` per metre too near to a robot.
        """
        soon = len(self.times)
        far = np.hypot(candidates[0] - leader[:, 0], candidates[1] - leader[:, 1])
        costs: Array = np.square(np.maximum(far[:, :soon] - self._length, 0.0)).sum(axis=1) / soon
        costs += LEVER * (np.maximum(self._room - far, 0.0).sum(axis=1) / candidates.shape[2])
        limit = self._length
        for other in others:
            short = np.maximum(KEEP - _gaps(candidates[:, :, :soon], other, self._half), 0.0)
            costs += LEVER * (short.sum(axis=1) / soon + short.max(axis=1))
            if short[0].any():  # the robot cannot stay where it is
                limit = self._room
        costs[(far < np.minimum(limit, np.minimum.accumulate(far[0]) - NEARER)).any(axis=1)] = math.inf
        return costs

    def _runs_within(self, room: Room) -> Array:
        """Signed distances driven by the candidates of `_arcs` at the k times `leader_times`, shape (n, k) [m]."""
        reach = np.concatenate([[0.0], *[room.ahead] * len(SPEEDS), *[room.behind] * len(SPEEDS)])[:, None]
        runs: Array = self._signs * braked_distance(self._speeds, reach, self.leader_times, self._braking)
        return runs
