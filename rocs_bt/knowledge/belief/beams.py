"""Beams: from the ranges of a ring of sonars, or of a scanner, to the things that they show."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...geometry import Pose2, wrap_angle
from .belief import Array, Sighting, Track

BESIDE = 0.15
"""Echoes of neighbouring beams that are farther apart than this and the beams themselves are of two things [m]."""

LEAST = 0.05
"""The radius of a thing of which a single narrow beam tells [m]."""

MARGIN = 0.15
"""An echo so much nearer than a thing hides it [m]."""


@dataclass(frozen=True)
class Beams:
    """How the beams of one sensor stand.

    Attributes:
        mounts: Where each begins and looks, in the body frame: x [m], y [m], bearing [rad]; neighbours in turn.
        half_angle: Of each beam's cone [rad].
        reach: How far they look [m].
        noise: Standard deviation of a range [m].
        largest: What reaches over more than this is a wall and no thing [m].
    """

    mounts: Sequence[tuple[float, float, float]]
    half_angle: float
    reach: float
    noise: float = 0.02
    largest: float = 0.8

    def __post_init__(self) -> None:
        if not self.mounts or any(len(mount) != 3 for mount in self.mounts):
            raise InputError("beams need a mount of x, y and bearing each.")
        sizes = (self.half_angle, self.reach, self.noise, self.largest)
        if not all(0.0 < size < math.inf for size in sizes):
            raise InputError(f"half_angle, reach, noise and largest must be above 0, found {sizes}.")

    def sightings(self, pose: Pose2, ranges: Sequence[float]) -> list[Sighting]:
        """The things that one reading shows; walls are left out.

        Args:
            pose: Where the robot is, world frame.
            ranges: By beam [m]; +inf without an echo, NaN where it tells nothing.
        """
        eyes, bearings = self._eyes(pose)
        found = np.asarray(ranges, float)
        heard = np.flatnonzero(found <= self.reach)  # false for NaN too
        points = eyes[heard] + found[heard, None] * np.column_stack([np.cos(bearings[heard]), np.sin(bearings[heard])])
        groups = self._groups(heard.tolist(), points, bearings[heard], found[heard])
        told = [self._sighting(pose, points[group], found[heard][group]) for group in groups]
        return [sighting for sighting in told if sighting is not None]

    def in_view(self, pose: Pose2, ranges: Sequence[float], track: Track) -> bool:
        """Whether a reading would have shown a thing: it is in a cone, within reach, and nothing nearer hides it."""
        eyes, bearings = self._eyes(pose)
        to = track.mean[:2] - eyes
        away = np.hypot(*to.T)
        off = np.abs(np.mod(np.arctan2(to[:, 1], to[:, 0]) - bearings + math.pi, math.tau) - math.pi)
        nearest = away - track.radius
        shown = (off <= self.half_angle) & (nearest <= self.reach - MARGIN)
        clear = np.asarray(ranges, float) >= nearest - MARGIN  # false for NaN: who sees nothing knows nothing
        return bool((shown & clear).any())

    def _eyes(self, pose: Pose2) -> tuple[Array, Array]:
        """(n, 2) and (n,) Where the beams begin and look, world frame."""
        mounts, c, s = np.array(self.mounts, float), math.cos(pose.yaw), math.sin(pose.yaw)
        eyes = mounts[:, :2] @ np.array([[c, s], [-s, c]]) + (pose.x, pose.y)
        return eyes, mounts[:, 2] + pose.yaw

    def _groups(self, heard: list[int], points: Array, bearings: Array, found: Array) -> list[list[int]]:
        """Indices of the echoes of each thing."""
        groups: list[list[int]] = []
        for i in range(len(heard)):
            if i and heard[i] == heard[i - 1] + 1 and self._together(points, bearings, found, i - 1, i):
                groups[-1].append(i)
            else:
                groups.append([i])
        around = len(groups) > 1 and heard[0] == 0 and heard[-1] == len(self.mounts) - 1
        if around and self._ring and self._together(points, bearings, found, len(heard) - 1, 0):
            groups[0] = groups.pop() + groups[0]
        return groups

    @property
    def _ring(self) -> bool:
        """Whether the last beam stands beside the first."""
        step = abs(wrap_angle(self.mounts[1][2] - self.mounts[0][2])) if len(self.mounts) > 1 else 0.0
        return len(self.mounts) > 2 and abs(wrap_angle(self.mounts[0][2] - self.mounts[-1][2])) <= 2.0 * step

    def _together(self, points: Array, bearings: Array, found: Array, a: int, b: int) -> bool:
        apart = abs(wrap_angle(float(bearings[b] - bearings[a]))) * min(found[a], found[b])
        return bool(np.hypot(*(points[b] - points[a])) <= BESIDE + apart)

    def _sighting(self, pose: Pose2, points: Array, found: Array) -> Sighting | None:
        extent = float(np.hypot(*(points[-1] - points[0])))
        if extent > self.largest:
            return None
        middle, radius = points.mean(axis=0), max(0.5 * extent, LEAST)
        to = middle - (pose.x, pose.y)
        away = float(np.hypot(*to))
        along = to / away if away > 1e-9 else np.array([1.0, 0.0])
        across = np.array([-along[1], along[0]])
        aside = float(found.min()) * math.tan(min(self.half_angle, 1.0)) / math.sqrt(3.0 * len(points))
        near, wide = self.noise**2 + (0.5 * radius) ** 2, aside**2 + self.noise**2
        covariance = near * np.outer(along, along) + wide * np.outer(across, across)
        return Sighting(middle + radius * along, covariance, radius)
