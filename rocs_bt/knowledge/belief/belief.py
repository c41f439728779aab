"""Belief: tracks of objects with uncertain existence and position, started, updated and ended by sightings.

A track is a Kalman filter of position and velocity with a constant-velocity model disturbed by white acceleration
(Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, 6.3.2). Its existence
is a probability: a sighting increases it, a scan that should have shown the object but did not decreases it (Mahler,
Statistical Multisource-Multitarget Information Fusion, 2007, the Bernoulli filter), and it decays while the object is
out of view.

Sightings are assigned to tracks within a gate by global nearest neighbour: the sum of the squared Mahalanobis distances
is minimal (Blackman and Popoli, Design and Analysis of Modern Tracking Systems, 1999, 6.4). Each unassigned sighting
starts a new track, which is reported only once its existence is high enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...errors import InputError

Array = npt.NDArray[np.float64]


class Sighting(NamedTuple):
    """Measured position of an object.

    Attributes:
        position: Position in the world frame [m], shape (2,).
        covariance: Covariance of the position [m2], shape (2, 2).
        radius: Radius of the object around its position [m].
    """

    position: Array
    covariance: Array
    radius: float


_MEASURES_POSITION = np.eye(2, 4)


@dataclass
class Track:
    """State estimate of one object.

    Attributes:
        mean: x, y [m] and their velocities [m/s], world frame, shape (4,).
        covariance: Covariance of `mean`, shape (4, 4).
        radius: Radius of the object around its position [m].
        existence: Probability that the object exists.
        t: Time of the estimate [s].
        seen: Time of the last sighting [s].
    """

    mean: Array
    covariance: Array
    radius: float
    existence: float
    t: float
    seen: float

    @classmethod
    def start(cls, t: float, sighting: Sighting, existence: float, speed: float) -> Track:
        """A track of an object that was seen for the first time.

        Args:
            t: Present time [s].
            sighting: First sighting.
            existence: Probability that the object exists.
            speed: Standard deviation of either velocity [m/s].
        """
        covariance = np.diag([0.0, 0.0, speed**2, speed**2])
        covariance[:2, :2] = sighting.covariance
        mean = np.array([*sighting.position, 0.0, 0.0])
        return cls(mean, covariance, sighting.radius, existence, t, t)

    @property
    def speed(self) -> float:
        """Speed of the object [m/s]."""
        return math.hypot(self.mean[2], self.mean[3])

    def predict(self, t: float, acceleration: float, half_life: float) -> None:
        """Predict the state at a later time; an earlier time has no effect.

        Args:
            t: Time of the prediction [s].
            acceleration: Spectral density of the disturbing acceleration [m2/s3].
            half_life: Time in which the existence of an unseen object halves [s].
        """
        dt = t - self.t
        if dt <= 0.0:
            return
        step = np.eye(4)
        step[0, 2] = step[1, 3] = dt
        self.mean = step @ self.mean
        self.covariance = step @ self.covariance @ step.T + acceleration * _disturbance(dt)
        self.existence *= 0.5 ** (dt / half_life)
        self.t = t

    def distances(self, positions: Array, covariances: Array) -> Array:
        """Squared Mahalanobis distances of sightings, shape (n,); 99 % of the object's own are below 9.21.

        Args:
            positions: Positions in the world frame [m], shape (n, 2).
            covariances: Covariances of the positions [m2], shape (n, 2, 2).
        """
        dx, dy = (positions - self.mean[:2]).T
        spread = covariances + self.covariance[:2, :2]
        a, b, d = spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]
        squared: Array = (d * dx * dx - 2.0 * b * dx * dy + a * dy * dy) / (a * d - b * b)
        return squared

    def update(self, sighting: Sighting, detection: float, clutter: float) -> None:
        """Update the state with a sighting of this object.

        Args:
            sighting: Sighting.
            detection: Probability of a sighting if the object exists.
            clutter: Probability of a sighting if the object does not exist.
        """
        across = self.covariance[:, :2]
        innovation = self.covariance[:2, :2] + sighting.covariance
        gain = np.linalg.solve(innovation, across.T).T
        self.mean = self.mean + gain @ (sighting.position - self.mean[:2])
        rest = np.eye(4) - gain @ _MEASURES_POSITION
        # Joseph form: stays symmetric and positive definite despite rounding.
        self.covariance = rest @ self.covariance @ rest.T + gain @ sighting.covariance @ gain.T
        self.radius += 0.2 * (sighting.radius - self.radius)
        there = self.existence * detection
        self.existence = there / (there + (1.0 - self.existence) * clutter)
        self.seen = self.t

    def miss(self, detection: float) -> None:
        """Update the existence after a scan that did not show the object.

        Args:
            detection: Probability of a sighting if the object exists.
        """
        there = self.existence * (1.0 - detection)
        self.existence = there / (there + 1.0 - self.existence)


def _disturbance(dt: float) -> Array:
    """Process noise covariance for white acceleration of density 1 m2/s3 over a time [s], shape (4, 4)."""
    q = np.zeros((4, 4))
    for i in (0, 1):
        q[i, i], q[i, i + 2], q[i + 2, i], q[i + 2, i + 2] = dt**3 / 3.0, dt**2 / 2.0, dt**2 / 2.0, dt
    return q


@dataclass(frozen=True)
class BeliefSettings:
    """Parameters of the tracking filter.

    Attributes:
        detection: Probability that a scan shows an object that exists and is in view.
        clutter: Probability of a sighting without an object.
        initial: Existence of an object after its first sighting.
        confirmed: Existence above which a track is reported.
        forgotten: Existence below which a track is deleted.
        half_life: Time in which the existence of an unseen object halves [s].
        gate: Maximum squared Mahalanobis distance between a sighting and its track; 99 % of the sightings of an object
            are within 9.21 (chi-square with two degrees of freedom).
        start_speed: Standard deviation of either velocity of a new track [m/s].
        acceleration: Spectral density of the disturbing acceleration [m2/s3].
    """

    detection: float = 0.8
    clutter: float = 0.2
    initial: float = 0.3
    confirmed: float = 0.6
    forgotten: float = 0.1
    half_life: float = 10.0
    gate: float = 9.21
    start_speed: float = 0.3
    acceleration: float = 0.05

    def __post_init__(self) -> None:
        chances = (self.detection, self.clutter, self.initial, self.confirmed, self.forgotten)
        if not all(0.0 < chance < 1.0 for chance in chances) or not self.forgotten < self.initial < self.confirmed:
            raise InputError(
                f"probabilities must be between 0 and 1, and forgotten < initial < confirmed, found {chances}."
            )
        if self.clutter >= self.detection:
            raise InputError(f"clutter must be below detection, found {self.clutter} and {self.detection}.")
        sizes = (self.half_life, self.gate, self.start_speed, self.acceleration)
        if not all(0.0 < size < math.inf for size in sizes):
            raise InputError(f"half_life, gate, start_speed and acceleration must be above 0, found {sizes}.")


@dataclass(frozen=True)
class BeliefUpdate:
    """Confirmed tracks that one scan added and removed.

    Attributes:
        appeared: Numbers of newly confirmed tracks.
        vanished: Numbers of deleted tracks that had been confirmed.
    """

    appeared: Sequence[int]
    vanished: Sequence[int]


class Belief:
    """Multi-object tracker.

    Args:
        settings: Parameters of the filter; None for the defaults.
    """

    def __init__(self, settings: BeliefSettings | None = None) -> None:
        self.settings = settings or BeliefSettings()
        self._tracks: dict[int, Track] = {}
        self._confirmed: set[int] = set()
        self._count = 0

    @property
    def confirmed(self) -> Mapping[int, Track]:
        """The confirmed tracks, by number."""
        return {number: self._tracks[number] for number in sorted(self._confirmed)}

    def update(self, t: float, sightings: Sequence[Sighting], in_view: Callable[[Track], bool]) -> BeliefUpdate:
        """Update the tracks with one scan.

        Args:
            t: Time of the scan [s].
            sightings: Sightings of the scan.
            in_view: Test of whether the scan would have shown the object of a track.
        """
        given = self.settings
        for track in self._tracks.values():
            track.predict(t, given.acceleration, given.half_life)
        pairs = self._assigned(sightings)
        for number, track in self._tracks.items():
            if number in pairs:
                track.update(sightings[pairs[number]], given.detection, given.clutter)
            elif in_view(track):
                track.miss(given.detection)
        for i in sorted(set(range(len(sightings))) - set(pairs.values())):
            self._count += 1
            self._tracks[self._count] = Track.start(t, sightings[i], given.initial, given.start_speed)
        return self._settled()

    def _assigned(self, sightings: Sequence[Sighting]) -> dict[int, int]:
        """Index of the sighting assigned to each track, by track number; unassigned tracks are omitted."""
        if not self._tracks or not sightings:
            return {}
        from scipy.optimize import linear_sum_assignment

        numbers = list(self._tracks)
        positions, covariances = np.array([s.position for s in sightings]), np.array([s.covariance for s in sightings])
        cost: Array = np.array([self._tracks[n].distances(positions, covariances) for n in numbers])
        far = 1e6
        rows, columns = linear_sum_assignment(np.where(cost <= self.settings.gate, cost, far))
        return {numbers[r]: int(c) for r, c in zip(rows, columns, strict=True) if cost[r, c] <= self.settings.gate}

    def _settled(self) -> BeliefUpdate:
        given = self.settings
        gone = [number for number, track in self._tracks.items() if track.existence < given.forgotten]
        for number in gone:
            del self._tracks[number]
        vanished = sorted(self._confirmed.intersection(gone))
        self._confirmed.difference_update(gone)
        appeared = [
            n for n, track in self._tracks.items() if track.existence >= given.confirmed and n not in self._confirmed
        ]
        self._confirmed.update(appeared)
        return BeliefUpdate(appeared, vanished)
