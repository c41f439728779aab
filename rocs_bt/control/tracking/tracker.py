"""Tracker: Kalman filters of the objects that the scans of one sensor show.

A track is a Kalman filter of position and velocity with a constant-velocity model disturbed by white acceleration
(Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, 6.3.3). Its existence
is a probability: a detection increases it, a scan that should have shown the object but did not decreases it (Mahler,
Statistical Multisource-Multitarget Information Fusion, 2007, the Bernoulli filter), and it decays while the object is
out of view. Segments are assigned to tracks by global nearest neighbour (Blackman and Popoli, Design and Analysis of
Modern Tracking Systems, 1999, 6.4).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields

import numpy as np
import numpy.typing as npt

from ...base.errors import InputError
from ..locomotion import Array
from .beams import Scan
from .past_scans import PastScans
from .segments import Segments

Numbers = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]

GATE = 13.8
"""Maximum squared Mahalanobis distance of a segment from its track; 99.9 % of an object's own are within it."""

REACH = 0.8
"""Maximum distance of a segment from its track [m]."""

GUESSED = 0.06
"""Standard deviation of the first guess of a segment's centre [m]."""

SIZE = 10.0
"""Difference of the radii that counts as much as one standard deviation of the position, as its inverse [1/m]."""

SURE_SIZE = 4
"""Number of detections of a whole object from which its radius is used when a part of it is hidden."""

RADIUS_GAIN = 0.15
"""Least weight of a new measurement of a radius."""

FLAT = 0.04
"""Root mean square distance of the echoes from a circle above which a segment starts no track [m]."""

DETECTION, CLUTTER, INITIAL = 0.8, 0.2, 0.3
"""Probabilities of a detection of an object in view, of one without an object, and that a new track is an object."""

CONFIRMED, FORGOTTEN = 0.6, 0.1
"""Existence from which a track is reported, and below which it is deleted."""

HITS = 3
"""Number of detections from which a track can be said to move."""

DEVIATIONS = 2.0
"""A track is fast if its speed exceeds this number of its standard deviations."""

TENTATIVE = 0.3
"""Time out of view after which an object that has not been confirmed is forgotten [s]."""

AT_REST = 5.0
"""Time after which a mover that stays in place counts as static [s]."""


@dataclass(frozen=True)
class TrackerSettings:
    """Parameters of the tracker.

    Attributes:
        acceleration: Standard deviation of the acceleration of an object, constant within a scan [m/s2].
        speed_noise: Standard deviation of either velocity of a new track [m/s].
        min_speed: Speed below which an object counts as standing [m/s].
        half_life: Time out of view in which the existence of an object halves [s].
        memory: Time out of view after which a mover is forgotten [s].
    """

    acceleration: float = 1.5
    speed_noise: float = 1.0
    min_speed: float = 0.15
    half_life: float = 10.0
    memory: float = 2.0

    def __post_init__(self) -> None:
        for name in (each.name for each in fields(self)):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} must be above 0, found {getattr(self, name)}.")


def _rows(*shape: int) -> Array:
    return np.zeros((0, *shape))


@dataclass(eq=False)
class TrackedObjects:
    """State estimates of n objects; the tracker changes the arrays.

    Attributes:
        ids: Numbers of the tracks, shape (n,).
        mean: x, y [m] and their velocities [m/s], world frame, shape (n, 4).
        covariance: Covariances of `mean`, shape (n, 4, 4).
        radius: Radii, shape (n,) [m].
        existence: Probabilities that the objects exist, shape (n,).
        seen: Times of the last detections, shape (n,) [s].
        hits: Numbers of detections, shape (n,).
        sized: Numbers of detections of the whole object, which measure its radius, shape (n,).
        moved: Times of the last motion, shape (n,) [s].
        confirmed: Whether each track has been reported, shape (n,).
    """

    ids: Numbers = field(default_factory=lambda: np.zeros(0, np.int64))
    mean: Array = field(default_factory=lambda: _rows(4))
    covariance: Array = field(default_factory=lambda: _rows(4, 4))
    radius: Array = field(default_factory=_rows)
    existence: Array = field(default_factory=_rows)
    seen: Array = field(default_factory=_rows)
    hits: Numbers = field(default_factory=lambda: np.zeros(0, np.int64))
    sized: Numbers = field(default_factory=lambda: np.zeros(0, np.int64))
    moved: Array = field(default_factory=_rows)
    confirmed: Flags = field(default_factory=lambda: np.zeros(0, np.bool_))

    def __len__(self) -> int:
        return len(self.ids)

    def taken(self, chosen: Flags) -> TrackedObjects:
        """The tracks that a mask chooses."""
        return self if chosen.all() else TrackedObjects(*(getattr(self, each.name)[chosen] for each in fields(self)))

    def joined(self, other: TrackedObjects) -> TrackedObjects:
        """These tracks and others."""
        names = [each.name for each in fields(self)]
        return TrackedObjects(*(np.concatenate([getattr(self, n), getattr(other, n)]) for n in names))

    @property
    def speed(self) -> Array:
        """Speeds, shape (n,) [m/s]."""
        return np.hypot(self.mean[:, 2], self.mean[:, 3])

    @property
    def speed_deviation(self) -> Array:
        """Standard deviations of the less certain velocity, shape (n,) [m/s]."""
        return np.sqrt(np.maximum(self.covariance[:, 2, 2], self.covariance[:, 3, 3]))

    def fast(self, min_speed: float) -> Flags:
        """Whether the speed of each object is certainly above a minimum [m/s], shape (n,)."""
        fast: Flags = self.speed > np.maximum(min_speed, DEVIATIONS * self.speed_deviation)
        return fast

    def movers(self, t: float) -> Flags:
        """Whether each object has moved within the last `AT_REST` seconds, shape (n,)."""
        return t - self.moved <= AT_REST


class Tracker:
    """Multi-object tracker.

    Args:
        settings: Parameters of the filter; None for the defaults.

    Attributes:
        tracks: Present tracks.
    """

    def __init__(self, settings: TrackerSettings | None = None) -> None:
        self.settings = settings or TrackerSettings()
        self.tracks = TrackedObjects()
        self._past = PastScans()
        self._count = 0
        self._t = math.nan

    def update(self, t: float, segments: Segments) -> None:
        """Update the tracks with one scan.

        Args:
            t: Time stamp of the scan [s]; not before that of the last one.
            segments: Segments of the scan that may be objects.
        """
        self._predict(t)
        tracks = self.tracks
        rows, columns = _pairs(tracks, segments)
        radius = self._sized(segments, rows, columns)
        centres, covariances, errors = segments.fitted(radius)
        late = segments.mean(segments.scan.beams.offsets[segments.beams])[columns] if len(rows) else np.zeros(0)
        measured = centres[columns] - late[:, None] * tracks.mean[rows, 2:]
        self._correct(rows, measured, covariances[columns])
        self._relocate(rows, measured, covariances[columns], segments.hidden[columns] == 0)
        owner = np.zeros(len(segments.scan.ranges), np.int64)
        numbers = np.zeros(len(segments), np.int64)
        numbers[columns] = tracks.ids[rows]
        owner[segments.beams] = np.repeat(numbers, segments.counts)
        self._past.add(t, segments.scan, owner)
        self._judge(t, rows, segments.scan)
        fresh = ((segments.hidden == 0) | ((segments.hidden == 1) & segments.round)) & (errors < FLAT)
        fresh[columns] = False
        fresh &= ~_inside(centres, tracks)
        self._start(t, centres[fresh], covariances[fresh], radius[fresh])
        self._settle(t)

    def _predict(self, t: float) -> None:
        dt, tracks = t - self._t, self.tracks
        self._t = t
        if not (dt > 0.0 and len(tracks)):
            return
        step = np.eye(4)
        step[0, 2] = step[1, 3] = dt
        push = np.kron([[0.5 * dt**2], [dt]], np.eye(2))
        tracks.mean = tracks.mean @ step.T
        tracks.covariance = step @ tracks.covariance @ step.T + self.settings.acceleration**2 * push @ push.T
        tracks.existence *= 0.5 ** (dt / self.settings.half_life)

    def _sized(self, segments: Segments, rows: Numbers, columns: Numbers) -> Array:
        """Update the radii of tracks; return the radius of each segment, that of its track if a part is hidden."""
        tracks, whole = self.tracks, segments.hidden[columns] == 0
        tracks.sized[rows] += whole
        gain = np.maximum(RADIUS_GAIN, 1.0 / np.maximum(tracks.sized[rows], 1))
        tracks.radius[rows] += np.where(whole, gain, 0.0) * (segments.radius[columns] - tracks.radius[rows])
        radius, known = segments.radius.copy(), ~whole & (tracks.sized[rows] >= SURE_SIZE)
        radius[columns[known]] = tracks.radius[rows[known]]
        return radius

    def _correct(self, rows: Numbers, centres: Array, noise: Array) -> None:
        """Kalman updates of tracks with measured centres, shape (k, 2), of covariances `noise`, shape (k, 2, 2)."""
        tracks = self.tracks
        before = tracks.covariance[rows]
        gain = before[:, :, :2] @ np.linalg.inv(before[:, :2, :2] + noise)
        tracks.mean[rows] += (gain @ (centres - tracks.mean[rows, :2])[..., None])[..., 0]
        rest = np.eye(4) - np.concatenate([gain, np.zeros_like(gain)], axis=2)
        # Joseph form: stays symmetric and positive definite despite rounding.
        tracks.covariance[rows] = rest @ before @ rest.transpose(0, 2, 1) + gain @ noise @ gain.transpose(0, 2, 1)

    def _relocate(self, rows: Numbers, centres: Array, noise: Array, whole: Flags) -> None:
        """Restart the positions of objects that are seen whole for the first time: the guessed radius was no motion."""
        tracks, first = self.tracks, whole & (self.tracks.sized[rows] == 1)
        if not first.any():
            return
        chosen = rows[first]
        tracks.mean[chosen, :2] = centres[first]
        tracks.covariance[chosen, :2, 2:] = tracks.covariance[chosen, 2:, :2] = 0.0
        tracks.covariance[chosen, :2, :2] = noise[first]

    def _judge(self, t: float, rows: Numbers, scan: Scan) -> None:
        """Update existence and motion of the tracks that the scan shows, at indices `rows`, or shows to be absent."""
        tracks, seen = self.tracks, np.zeros(len(self.tracks), np.bool_)
        seen[rows] = True
        missed, unseen = np.zeros_like(seen), np.flatnonzero(~seen)
        if len(unseen):
            missed[unseen] = scan.sees_past(tracks.mean[unseen, :2], tracks.radius[unseen])
        there = tracks.existence * np.where(seen, DETECTION, np.where(missed, 1.0 - DETECTION, 1.0))
        absent = (1.0 - tracks.existence) * np.where(seen, CLUTTER, 1.0)
        tracks.existence = there / (there + absent)
        tracks.seen[seen] = t
        tracks.hits += seen
        fast = seen & (tracks.hits >= HITS) & tracks.fast(self.settings.min_speed)
        for i in np.flatnonzero(fast & ~tracks.movers(t)):
            fast[i] = self._past.moved(int(tracks.ids[i]))
        tracks.moved[fast] = t

    def _start(self, t: float, centres: Array, covariances: Array, radius: Array) -> None:
        if not (n := len(centres)):
            return
        covariance = np.zeros((n, 4, 4))
        covariance[:, :2, :2] = covariances
        covariance[:, 2, 2] = covariance[:, 3, 3] = self.settings.speed_noise**2
        new = TrackedObjects(
            ids=self._count + 1 + np.arange(n),
            mean=np.column_stack([centres, np.zeros((n, 2))]),
            covariance=covariance,
            radius=radius,
            existence=np.full(n, INITIAL),
            seen=np.full(n, t),
            hits=np.ones(n, np.int64),
            sized=np.zeros(n, np.int64),
            moved=np.full(n, -math.inf),
            confirmed=np.zeros(n, np.bool_),
        )
        self._count += n
        self.tracks = self.tracks.joined(new)

    def _settle(self, t: float) -> None:
        """Delete and confirm tracks."""
        tracks = self.tracks
        unseen = t - tracks.seen
        gone = (tracks.existence < FORGOTTEN) | (~tracks.confirmed & (unseen > TENTATIVE))
        gone |= tracks.movers(t) & (unseen > self.settings.memory)
        tracks = self.tracks = tracks.taken(~gone)
        tracks.confirmed = tracks.confirmed | (tracks.existence >= CONFIRMED)


def _inside(points: Array, tracks: TrackedObjects) -> Flags:
    """Whether each point is inside an object that is tracked already, such as a second part of it, shape (s,)."""
    dx, dy = (points[:, None] - tracks.mean[:, :2]).transpose(2, 0, 1)
    inside: Flags = (np.hypot(dx, dy) < tracks.radius).any(axis=1)
    return inside


def _pairs(tracks: TrackedObjects, segments: Segments) -> tuple[Numbers, Numbers]:
    """Indices of the tracks and of the segments that are assigned to each other."""
    if not len(tracks) or not len(segments):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    from scipy.optimize import linear_sum_assignment

    dx, dy = (segments.centre - tracks.mean[:, None, :2]).transpose(2, 0, 1)
    spread = tracks.covariance[:, :2, :2] + GUESSED**2 * np.eye(2)
    a, b, c = spread[:, 0, 0, None], spread[:, 0, 1, None], spread[:, 1, 1, None]
    squared = (c * dx * dx - 2.0 * b * dx * dy + a * dy * dy) / (a * c - b * b)
    near = (squared <= GATE) & (dx * dx + dy * dy <= REACH**2)
    cost = squared + (SIZE * (segments.radius - tracks.radius[:, None])) ** 2
    rows, columns = linear_sum_assignment(np.where(near, cost, 1e6))
    kept = near[rows, columns]
    return rows[kept], columns[kept]
