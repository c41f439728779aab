"""Belief: what may be there, how surely, and where: tracks that sightings begin, move and end.

A track is a Kalman filter of position and velocity. It moves with a constant velocity that white accelerations disturb
(Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, 6.3.2). Its existence
is a probability: a sighting is evidence for it, a look that should have shown it and did not is evidence against it
(Mahler, Statistical Multisource-Multitarget Information Fusion, 2007, the Bernoulli filter), and while no sensor looks
it decays.

Sightings are given to tracks such that the sum of the squared Mahalanobis distances is least (global nearest neighbour;
Blackman and Popoli, Design and Analysis of Modern Tracking Systems, 1999, 6.4), within a gate. Each that is left over
begins a new track, which is reported only once it is sure enough.
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
    """Where something was seen.

    Attributes:
        position: (2,) In the world frame [m].
        covariance: (2, 2) Of the position [m2].
        radius: How far it reaches around its position [m].
    """

    position: Array
    covariance: Array
    radius: float


_SEES_POSITION = np.eye(2, 4)


@dataclass
class Track:
    """One thing.

    Attributes:
        mean: (4,) x, y [m] and their velocities [m/s], world frame.
        covariance: (4, 4) Of the mean.
        radius: How far it reaches around its position [m].
        existence: The probability that it is there.
        t: The time that all this is about [s].
        seen: When it was seen last [s].
    """

    mean: Array
    covariance: Array
    radius: float
    existence: float
    t: float
    seen: float

    @classmethod
    def start(cls, t: float, sighting: Sighting, existence: float, speed: float) -> Track:
        """A track of what was just seen for the first time.

        Args:
            t: Now [s].
            sighting: What was seen.
            existence: The probability that it is there.
            speed: Standard deviation of either velocity [m/s].
        """
        covariance = np.diag([0.0, 0.0, speed**2, speed**2])
        covariance[:2, :2] = sighting.covariance
        mean = np.array([*sighting.position, 0.0, 0.0])
        return cls(mean, covariance, sighting.radius, existence, t, t)

    @property
    def speed(self) -> float:
        """How fast it moves [m/s]."""
        return math.hypot(self.mean[2], self.mean[3])

    def predict(self, t: float, acceleration: float, half_life: float) -> None:
        """Move on to a time; an earlier one changes nothing.

        Args:
            t: To when [s].
            acceleration: Density of the accelerations that disturb it [m2/s3].
            half_life: After how long unseen its existence is half as sure [s].
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
        """(n,) Squared Mahalanobis distances of sightings; of what is truly its own 99 of 100 are below 9.21.

        Args:
            positions: (n, 2) In the world frame [m].
            covariances: (n, 2, 2) Of the positions [m2].
        """
        dx, dy = (positions - self.mean[:2]).T
        spread = covariances + self.covariance[:2, :2]
        a, b, d = spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]
        squared: Array = (d * dx * dx - 2.0 * b * dx * dy + a * dy * dy) / (a * d - b * b)
        return squared

    def update(self, sighting: Sighting, detection: float, clutter: float) -> None:
        """Take a sighting as this thing's own.

        Args:
            sighting: What was seen.
            detection: How probable it was that it be seen, if it is there.
            clutter: How probable such a sighting is, if it is not.
        """
        across = self.covariance[:, :2]
        innovation = self.covariance[:2, :2] + sighting.covariance
        gain = np.linalg.solve(innovation, across.T).T
        self.mean = self.mean + gain @ (sighting.position - self.mean[:2])
        rest = np.eye(4) - gain @ _SEES_POSITION
        # Joseph's form: symmetric and positive whatever rounding does.
        self.covariance = rest @ self.covariance @ rest.T + gain @ sighting.covariance @ gain.T
        self.radius += 0.2 * (sighting.radius - self.radius)
        there = self.existence * detection
        self.existence = there / (there + (1.0 - self.existence) * clutter)
        self.seen = self.t

    def miss(self, detection: float) -> None:
        """Note that a look did not show it.

        Args:
            detection: How probable it was that it be seen, if it is there.
        """
        there = self.existence * (1.0 - detection)
        self.existence = there / (there + 1.0 - self.existence)


def _disturbance(dt: float) -> Array:
    """(4, 4) What white accelerations of density 1 m2/s3 add in a time [s]."""
    q = np.zeros((4, 4))
    for i in (0, 1):
        q[i, i], q[i, i + 2], q[i + 2, i], q[i + 2, i + 2] = dt**3 / 3.0, dt**2 / 2.0, dt**2 / 2.0, dt
    return q


@dataclass(frozen=True)
class BeliefSettings:
    """What is taken for granted of things and of looks.

    Attributes:
        detection: How probable it is that a look shows what is there and in view.
        clutter: How probable a sighting is where nothing is.
        first: Existence of what was seen once.
        sure: Existence above which a thing is told of.
        gone: Existence below which it is forgotten.
        half_life: After how long unseen its existence is half as sure [s].
        gate: The squared Mahalanobis distance within which a sighting may belong to a track; of what belongs to it
            99 of 100 are within 9.21 (chi-square of two degrees of freedom).
        start_speed: Standard deviation of either velocity of what is new [m/s].
        acceleration: Density of the accelerations that disturb it [m2/s3].
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
    """What one look did.

    Attributes:
        appeared: Numbers of tracks that are sure now and were not.
        vanished: Numbers of tracks that were told of and are forgotten.
    """

    appeared: Sequence[int]
    vanished: Sequence[int]


class Belief:
    """Things that may be there.

    Args:
        settings: What to take for granted.
    """

    def __init__(self, settings: BeliefSettings | None = None) -> None:
        self.settings = settings or BeliefSettings()
        self._tracks: dict[int, Track] = {}
        self._confirmed: set[int] = set()
        self._count = 0

    @property
    def confirmed(self) -> Mapping[int, Track]:
        """The tracks that are told of, by number."""
        return {number: self._tracks[number] for number in sorted(self._confirmed)}

    def update(self, t: float, sightings: Sequence[Sighting], in_view: Callable[[Track], bool]) -> BeliefUpdate:
        """Take one look.

        Args:
            t: When [s].
            sightings: What it showed.
            in_view: Whether it would have shown a track that is there.
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
        """Which sighting each track gets: by number, the index."""
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
