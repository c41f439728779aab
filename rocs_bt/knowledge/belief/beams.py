"""Detection of objects in the ranges of a sonar ring or a laser scanner."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...geometry import Pose2, wrap_angle
from .belief import Array, Sighting, Track

MAX_GAP = 0.15
"""Maximum gap between neighbouring echoes of one object, in addition to the spacing of the beams [m]."""

MIN_RADIUS = 0.05
"""Minimum radius of an object; that of an object seen by one beam [m]."""

OCCLUSION = 0.15
"""Distance by which an echo must be nearer than an object's near edge to hide the object [m]."""


@dataclass(frozen=True)
class Beams:
    """Geometry and noise of the beams of one range sensor.

    Attributes:
        mounts: Origin and direction of each beam, body frame: x [m], y [m], bearing [rad]; in the order of the
            bearings.
        half_angle: Half opening angle of each beam's cone [rad].
        max_range: Maximum range [m].
        noise: Standard deviation of a range [m].
        max_object_size: Maximum extent of an object; anything larger is a wall [m].
    """

    mounts: Sequence[tuple[float, float, float]]
    half_angle: float
    max_range: float
    noise: float = 0.02
    max_object_size: float = 0.8

    def __post_init__(self) -> None:
        if not self.mounts or any(len(mount) != 3 for mount in self.mounts):
            raise InputError("beams need a mount of x, y and bearing each.")
        sizes = (self.half_angle, self.max_range, self.noise, self.max_object_size)
        if not all(0.0 < size < math.inf for size in sizes):
            raise InputError(f"half_angle, reach, noise and largest must be above 0, found {sizes}.")

    def sightings(self, pose: Pose2, ranges: Sequence[float]) -> list[Sighting]:
        """Detect the objects in one scan; whatever is larger than `max_object_size` is left out as a wall.

        Args:
            pose: Pose of the robot, world frame.
            ranges: Range of each beam [m]; +inf without an echo, NaN if invalid.
        """
        origins, bearings = self._rays(pose)
        found = np.asarray(ranges, float)
        hits = np.flatnonzero(found <= self.max_range)  # false for NaN too
        points = origins[hits] + found[hits, None] * np.column_stack([np.cos(bearings[hits]), np.sin(bearings[hits])])
        groups = self._groups(hits.tolist(), points, bearings[hits], found[hits])
        sightings = [self._sighting(pose, points[group], found[hits][group]) for group in groups]
        return [sighting for sighting in sightings if sighting is not None]

    def in_view(self, pose: Pose2, ranges: Sequence[float], track: Track) -> bool:
        """Whether a scan would have shown a track's object: inside a beam's cone, within reach, and not hidden."""
        origins, bearings = self._rays(pose)
        to = track.mean[:2] - origins
        away = np.hypot(*to.T)
        off = np.abs(np.mod(np.arctan2(to[:, 1], to[:, 0]) - bearings + math.pi, math.tau) - math.pi)
        nearest = away - track.radius
        shown = (off <= self.half_angle) & (nearest <= self.max_range - OCCLUSION)
        clear = np.asarray(ranges, float) >= nearest - OCCLUSION  # false for NaN: an invalid beam shows nothing
        return bool((shown & clear).any())

    def _rays(self, pose: Pose2) -> tuple[Array, Array]:
        """Origins, shape (n, 2), and bearings, shape (n,), of the beams, world frame."""
        mounts, c, s = np.array(self.mounts, float), math.cos(pose.yaw), math.sin(pose.yaw)
        origins = mounts[:, :2] @ np.array([[c, s], [-s, c]]) + (pose.x, pose.y)
        return origins, mounts[:, 2] + pose.yaw

    def _groups(self, hits: list[int], points: Array, bearings: Array, found: Array) -> list[list[int]]:
        """Indices of the echoes of each object."""
        groups: list[list[int]] = []
        for i in range(len(hits)):
            if i and hits[i] == hits[i - 1] + 1 and self._same_object(points, bearings, found, i - 1, i):
                groups[-1].append(i)
            else:
                groups.append([i])
        around = len(groups) > 1 and hits[0] == 0 and hits[-1] == len(self.mounts) - 1
        if around and self._ring and self._same_object(points, bearings, found, len(hits) - 1, 0):
            groups[0] = groups.pop() + groups[0]
        return groups

    @property
    def _ring(self) -> bool:
        """Whether the beams form a full ring, so that the last is a neighbour of the first."""
        step = abs(wrap_angle(self.mounts[1][2] - self.mounts[0][2])) if len(self.mounts) > 1 else 0.0
        return len(self.mounts) > 2 and abs(wrap_angle(self.mounts[0][2] - self.mounts[-1][2])) <= 2.0 * step

    def _same_object(self, points: Array, bearings: Array, found: Array, a: int, b: int) -> bool:
        spacing = abs(wrap_angle(float(bearings[b] - bearings[a]))) * min(found[a], found[b])
        return bool(np.hypot(*(points[b] - points[a])) <= MAX_GAP + spacing)

    def _sighting(self, pose: Pose2, points: Array, found: Array) -> Sighting | None:
        extent = float(np.hypot(*(points[-1] - points[0])))
        if extent > self.max_object_size:
            return None
        middle, radius = points.mean(axis=0), max(0.5 * extent, MIN_RADIUS)
        to = middle - (pose.x, pose.y)
        away = float(np.hypot(*to))
        along = to / away if away > 1e-9 else np.array([1.0, 0.0])
        across = np.array([-along[1], along[0]])
        aside = float(found.min()) * math.tan(min(self.half_angle, 1.0)) / math.sqrt(3.0 * len(points))
        near, wide = self.noise**2 + (0.5 * radius) ** 2, aside**2 + self.noise**2
        covariance = near * np.outer(along, along) + wide * np.outer(across, across)
        return Sighting(middle + radius * along, covariance, radius)
