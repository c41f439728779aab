"""Tracks: step functions of the things that change in a run, each with its key."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from .states import TrackKey

T = TypeVar("T", "Steps", "Curve", "Steps | Curve")

_SLACK = 1e-6  # [s] times given by people are rounded
_MOST_RAYS = 120  # kept of a reading


class Span(NamedTuple):
    """Interval of a track in which its value is the same."""

    begin: float  # [s]
    end: float  # [s]
    value: Any


class Steps:
    """Step function of values of any kind; each value holds until the next one.

    Attributes:
        t: Times of the changes [s], ascending.
        v: Value from each of these times on.
    """

    def __init__(self) -> None:
        self.t: list[float] = []
        self.v: list[Any] = []

    def put(self, t: float, value: Any) -> None:
        """Set the value from a time on; a value that does not change costs nothing."""
        if self.v and self.v[-1] == value:
            return
        if self.t and self.t[-1] == t:
            self.v[-1] = value
        else:
            self.t.append(t)
            self.v.append(value)

    def add(self, t: float, value: Any) -> None:
        """Set the value from a time on, also if it does not change."""
        if self.t and self.t[-1] == t:
            self.v[-1] = value
            return
        self.t.append(t)
        self.v.append(self.v[-1] if self.v and self.v[-1] == value else value)

    def first(self, t: float, value: Any) -> None:
        """Set the only value of the track; later ones are ignored."""
        if not self.t:
            self.put(t, value)

    def at(self, t: float) -> Any:
        """Value at a time [s]; None before the first."""
        i = bisect_right(self.t, t + _SLACK) - 1
        return self.v[i] if i >= 0 else None

    def since(self, t: float) -> float:
        """Time from which the value at a time holds [s]; NaN before the first."""
        i = bisect_right(self.t, t + _SLACK) - 1
        return self.t[i] if i >= 0 else math.nan

    def spans(self, end: float) -> list[Span]:
        """Intervals of equal values, until the end of the run [s]."""
        return [Span(*each) for each in zip(self.t, [*self.t[1:], end], self.v, strict=False)]


class Curve:
    """Samples of numbers, all of one width.

    Attributes:
        t: Times of the samples [s], ascending.
        width: Number of values of a sample.
        data: Samples one after the other, SI units.
        max_age: Time after which a sample is no longer valid [s].
        stamps: Times to which the samples refer [s]; None if they equal `t`.
    """

    def __init__(self, width: int, max_age: float = math.inf) -> None:
        self.t: list[float] = []
        self.stamps: list[float] | None = None
        self.width = width
        self.data = array("d")
        self.max_age = max_age

    def add(self, t: float, sample: bytes | memoryview, stamp: float | None = None) -> None:
        """Append a sample, packed as float64; one of another width is dropped. `stamp` is the time it refers to [s]."""
        if len(sample) != 8 * self.width:
            return
        if stamp is not None and self.stamps is None:
            self.stamps = self.t[:]
        if self.stamps is not None:
            self.stamps.append(t if stamp is None else stamp)
        self.t.append(t)
        self.data.frombytes(sample)

    def stamp(self, i: int) -> float:
        """Time to which a sample refers [s]."""
        return self.t[i] if self.stamps is None else self.stamps[i]

    def at(self, t: float) -> Sequence[float]:
        """Sample at a time [s]; NaN before the first, and when the last is too old."""
        i = bisect_right(self.t, t + _SLACK) - 1
        if i < 0 or t - self.stamp(i) > self.max_age + _SLACK:
            return [math.nan] * self.width
        return self.data[i * self.width : (i + 1) * self.width].tolist()

    def last(self, t: float) -> tuple[float, list[float]] | None:
        """Time [s] and values of the last sample until a time, however old; None if there is none."""
        i = bisect_right(self.t, t + _SLACK) - 1
        return None if i < 0 else (self.t[i], self.data[i * self.width : (i + 1) * self.width].tolist())

    def extend(self, t: Sequence[float], rows: NDArray[np.float64]) -> None:
        """Append several samples, shape (n, width)."""
        self.t.extend(t)
        self.data.frombytes(np.ascontiguousarray(rows, np.float64).tobytes())

    def rows(self, first: int = 0) -> NDArray[np.float64]:
        """All samples from an index on, shape (n, width)."""
        return np.array(self.data[first * self.width :], np.float64).reshape(len(self.t) - first, self.width)


class Scans(Curve):
    """Readings of a scanner for display: of wide ones only every n-th ray, of a long run only every n-th reading.

    The newest reading is always the last sample, until the next one replaces it or is added after it.
    """

    def __init__(self, rays: int, most: int) -> None:
        self.ray = max(1, math.ceil(rays / _MOST_RAYS))  # rays of the scanner from one ray of a sample to the next
        super().__init__(len(range(0, rays, self.ray)))
        self._rays, self._most = rays, most
        self.every = 1  # readings from one kept sample to the next
        self._count = 0

    def add(self, t: float, sample: bytes | memoryview, stamp: float | None = None) -> None:
        """Append a reading, packed as float64; one with another number of rays is dropped."""
        if len(sample) != 8 * self._rays:
            return
        if (self._count - 1) % self.every and self.t:  # the last sample is not one to keep
            self.t.pop()
            del self.data[-self.width :]
        self._count += 1
        values = array("d")
        values.frombytes(sample)
        self.t.append(t)
        self.data.extend(values[:: self.ray])
        if len(self.t) > self._most:
            self._thin()

    def _thin(self) -> None:
        """Drop every second sample."""
        self.data = array("d", self.rows()[::2].reshape(-1))
        self.t = self.t[::2]
        self.every *= 2


class TrackSet:
    """Tracks by agent, topic and name."""

    def __init__(self) -> None:
        self._tracks: dict[TrackKey, Steps | Curve] = {}
        self._topics: dict[tuple[str, str], dict[str, Steps | Curve]] = {}

    def items(self) -> list[tuple[TrackKey, Steps | Curve]]:
        """All tracks with their keys, in the order in which they began."""
        return list(self._tracks.items())

    def get(self, agent: str, topic: str, name: str = "") -> Steps | Curve | None:
        """A track; None if nothing was recorded."""
        return self._tracks.get((agent, topic, name))  # type: ignore[call-overload,no-any-return]  # a Key, made faster

    def steps(self, agent: str, topic: str, name: str = "") -> Steps:
        """A track of values; an empty one if nothing was recorded."""
        track = self.get(agent, topic, name)
        return track if isinstance(track, Steps) else Steps()

    def curve(self, agent: str, topic: str, name: str = "") -> Curve:
        """A track of numbers; an empty one if nothing was recorded."""
        track = self.get(agent, topic, name)
        return track if isinstance(track, Curve) else Curve(0)

    def of(self, agent: str, topic: str) -> Mapping[str, Steps | Curve]:
        """All tracks of a topic of an agent, by name, in the order in which they began."""
        return self._topics.get((agent, topic), {})

    def steps_of(self, agent: str, topic: str) -> dict[str, Steps]:
        """Tracks of values of a topic."""
        return {name: track for name, track in self.of(agent, topic).items() if isinstance(track, Steps)}

    def curves_of(self, agent: str, topic: str) -> dict[str, Curve]:
        """Tracks of numbers of a topic."""
        return {name: track for name, track in self.of(agent, topic).items() if isinstance(track, Curve)}

    def state(self, t: float, agent: str, topic: str) -> dict[str, Any]:
        """Values at a time of all tracks of a topic of an agent, by name; without those that have none."""
        return {name: value for name, track in self.of(agent, topic).items() if (value := track.at(t)) is not None}

    def begun(self, agent: str, topic: str, name: str = "") -> Steps:
        """A track of values to add to; it begins if there is none."""
        track = self.get(agent, topic, name)
        return track if isinstance(track, Steps) else self.add(TrackKey(agent, topic, name), Steps())

    def add(self, key: TrackKey, track: T) -> T:
        """Add a track."""
        self._tracks[key] = self._topics.setdefault((key.agent, key.topic), {})[key.name] = track
        return track
