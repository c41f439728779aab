"""Belief: all tracks together, and which sighting belongs to which.

Sightings are given to tracks such that the sum of the squared Mahalanobis distances is least (global nearest neighbour;
Blackman and Popoli, Design and Analysis of Modern Tracking Systems, 1999, 6.4), within a gate. What is left over begins
a new track, which is told of only once it is sure enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from .sighting import Array, Sighting
from .track import Track


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
    first: float = 0.3
    sure: float = 0.6
    gone: float = 0.1
    half_life: float = 10.0
    gate: float = 9.21
    start_speed: float = 0.3
    acceleration: float = 0.05

    def __post_init__(self) -> None:
        chances = (self.detection, self.clutter, self.first, self.sure, self.gone)
        if not all(0.0 < chance < 1.0 for chance in chances) or not self.gone < self.first < self.sure:
            raise InputError(f"probabilities must be between 0 and 1, and gone < first < sure, found {chances}.")
        if self.clutter >= self.detection:
            raise InputError(f"clutter must be below detection, found {self.clutter} and {self.detection}.")
        sizes = (self.half_life, self.gate, self.start_speed, self.acceleration)
        if not all(0.0 < size < math.inf for size in sizes):
            raise InputError(f"half_life, gate, start_speed and acceleration must be above 0, found {sizes}.")


@dataclass(frozen=True)
class Seen:
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
        self._told: set[int] = set()
        self._count = 0

    @property
    def things(self) -> Mapping[int, Track]:
        """The tracks that are told of, by number."""
        return {number: self._tracks[number] for number in sorted(self._told)}

    def look(self, t: float, sightings: Sequence[Sighting], in_view: Callable[[Track], bool]) -> Seen:
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
            self._tracks[self._count] = Track.begun(t, sightings[i], given.first, given.start_speed)
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

    def _settled(self) -> Seen:
        given = self.settings
        gone = [number for number, track in self._tracks.items() if track.existence < given.gone]
        for number in gone:
            del self._tracks[number]
        vanished = sorted(self._told.intersection(gone))
        self._told.difference_update(gone)
        appeared = [n for n, track in self._tracks.items() if track.existence >= given.sure and n not in self._told]
        self._told.update(appeared)
        return Seen(appeared, vanished)
