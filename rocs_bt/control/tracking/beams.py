"""Beams of a sonar ring or a laser scanner, and the echoes of one scan in the world frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ...base.errors import InputError
from ...base.geometry import Pose2
from ..locomotion import Array

BEHIND = 0.15
"""Distance behind an object beyond which an echo shows that the object is not there [m]."""


@dataclass(frozen=True)
class Beams:
    """Geometry and noise of the beams of one range sensor.

    Attributes:
        mounts: Origin and direction of each beam, body frame: x [m], y [m], bearing [rad]; in the order of the
            bearings.
        half_angle: Half opening angle of each beam's cone [rad].
        max_range: Maximum range [m].
        noise: Standard deviation of a range [m].
        sweep: Time from the first beam of a scan to the last; a scan's time stamp is that of the first [s].
    """

    mounts: Sequence[tuple[float, float, float]]
    half_angle: float
    max_range: float
    noise: float = 0.02
    sweep: float = 0.0

    def __post_init__(self) -> None:
        if not self.mounts or any(len(mount) != 3 for mount in self.mounts):
            raise InputError("beams need a mount of x, y and bearing each.")
        sizes = (self.half_angle, self.max_range, self.noise)
        if not all(0.0 < size < math.inf for size in sizes) or not 0.0 <= self.sweep < math.inf:
            raise InputError(
                f"half_angle, max_range and noise must be above 0, and sweep at least 0, found {(*sizes, self.sweep)}."
            )

    @cached_property
    def _rays(self) -> Array:
        return np.array(self.mounts, float)

    @cached_property
    def spacing(self) -> float:
        """Median angle between neighbouring beams [rad]; a full turn for a single beam."""
        turns = np.abs(np.mod(np.diff(self._rays[:, 2]) + math.pi, math.tau) - math.pi)
        return float(np.median(turns)) if len(turns) else math.tau

    @cached_property
    def ring(self) -> bool:
        """Whether the beams form a full ring, so that the last is a neighbour of the first."""
        first, last = self._rays[0, 2], self._rays[-1, 2]
        return len(self.mounts) > 2 and abs(math.remainder(first - last, math.tau)) <= 2.0 * self.spacing

    @cached_property
    def offsets(self) -> Array:
        """Time of each beam after the time stamp of the scan, shape (b,) [s]."""
        return np.linspace(0.0, self.sweep, len(self.mounts))

    def scan(self, poses: Pose2 | Array, ranges: Sequence[float] | Array) -> Scan:
        """Place the ranges of one scan in the world.

        Args:
            poses: Pose of the robot, world frame, or its pose at the time of each beam, shape (b, 3) [m, m, rad].
            ranges: Range of each beam, shape (b,) [m]; +inf without an echo, NaN if invalid.
        """
        poses, rays = np.array(poses), self._rays
        x, y, yaw = poses.T
        c, s = np.cos(yaw), np.sin(yaw)
        eyes = np.column_stack([x + c * rays[:, 0] - s * rays[:, 1], y + s * rays[:, 0] + c * rays[:, 1]])
        bearings = rays[:, 2] + yaw
        found = np.asarray(ranges, float)
        heard = found <= self.max_range  # false for NaN too
        looks = np.column_stack([np.cos(bearings), np.sin(bearings)])
        points = eyes + np.where(heard, found, 0.0)[:, None] * looks
        return Scan(self, eyes, bearings, looks, found, heard, points)


@dataclass(frozen=True, eq=False)
class Scan:
    """One scan in the world frame.

    Attributes:
        beams: Geometry of the beams.
        eyes: Origins of the beams, shape (b, 2) [m].
        bearings: Directions of the beams, shape (b,) [rad].
        looks: The same as unit vectors, shape (b, 2).
        ranges: Ranges, shape (b,) [m].
        heard: Whether each beam has an echo within the maximum range, shape (b,).
        points: Positions of the echoes, shape (b, 2) [m]; meaningless without an echo.
    """

    beams: Beams
    eyes: Array
    bearings: Array
    looks: Array
    ranges: Array
    heard: npt.NDArray[np.bool_]
    points: Array

    def sees_past(self, positions: Array, radius: Array) -> npt.NDArray[np.bool_]:
        """Whether a beam through the middle of each object goes on behind it, so that the object is not there.

        Args:
            positions: Positions of the objects, shape (n, 2) [m].
            radius: Radii of the objects, shape (n,) [m].
        """
        dx, dy = positions[:, :1] - self.eyes[:, 0], positions[:, 1:] - self.eyes[:, 1]
        away, half = np.hypot(dx, dy), max(self.beams.half_angle, 0.5 * self.beams.spacing)
        through = dx * self.looks[:, 0] + dy * self.looks[:, 1] >= math.cos(half) * away
        behind = away + (radius[:, None] + BEHIND)
        within = behind <= self.beams.max_range
        past: npt.NDArray[np.bool_] = np.any(through & within & (self.ranges >= behind), axis=1)  # false for NaN
        return past
