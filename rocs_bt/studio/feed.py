"""Feed of a live page: the tracks of a run that goes on, and what each browser has got of them."""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import msgspec

from ..event import Event
from ..record import RunHeader
from ..record.explanation.comparisons import Comparisons
from ..record.fold.states import TrackKey, shown_number
from ..record.fold.track import Curve, Scans, Steps
from ..record.fold.tracks import Tracks
from .pack import TIME, Json, Numbers, address, head, items, log_line, opens_at, plain, samples_shown, text
from .requests import Stream

_DIGITS = 5
_RATE = 10.0  # [Hz] of updates of a browser
_QUIET = 50  # updates without a change, after which a comment is sent


class Feed:
    """Thread-safe tracks of one run that goes on: one thread feeds them, and each browser asks for what it lacks.

    Attributes:
        closed: Whether the run is over.
        version: Number that each change increases.
        about: Additions of the run's end, such as its results; None before.
    """

    def __init__(self, **extra: Any) -> None:
        self.closed = False
        self.version = 0
        self.about: Json | None = None
        self._extra = extra
        self._lock = threading.Lock()
        self._tracks: Tracks | None = None
        self._comparisons: Comparisons | None = None

    def begin(self, header: RunHeader, events: Iterable[Event] = ()) -> None:
        """Begin with the header of the run, and with the events so far; browsers wait until these are read."""
        tracks = Tracks(header)
        comparisons = Comparisons(tracks)
        tracks.take(events)
        comparisons.update()
        with self._lock:
            self._tracks, self._comparisons = tracks, comparisons
            self.version += 1

    def take(self, events: Sequence[Event]) -> None:
        """Take new events of the run."""
        with self._lock:
            if self._tracks is not None and self._comparisons is not None:
                self._tracks.take(events)
                self._comparisons.update()
                self.version += 1

    def close(self, about: Json | None = None) -> None:
        """End the feed: the browsers get what is left, and what is known about the end."""
        with self._lock:
            if self._comparisons is not None:
                self._comparisons.update(over=True)
            self.about = about
            self.closed = True
            self.version += 1

    def head(self) -> bytes:
        """JSON of what does not change, for a new browser; `null` before the run begins."""
        with self._lock:
            if self._tracks is None:
                return b"null"
            given = {**head(self._tracks.header), "end": self._tracks.end}
            return msgspec.json.encode({**given, **self._extra}, enc_hook=plain)

    def fresh(self, seen: Seen) -> bytes | None:
        """JSON of everything that a browser lacks; None if nothing is new."""
        with self._lock:
            if self._tracks is None or self.version == seen.version:
                return None
            seen.version = self.version
            return seen.message(self._tracks, opens_at(self._tracks), self.about)


async def updates(feed: Feed) -> Stream:
    """Server-sent events for one browser: what is new, at most 10 times a second, and `over` at the end of the run."""
    seen, quiet = Seen(), 0
    while True:
        closed, fresh = feed.closed, None
        if feed.version != seen.version:
            fresh = await asyncio.to_thread(feed.fresh, seen)
        quiet = 0 if fresh else quiet + 1
        if fresh is not None:
            yield b"data: %b\n\n" % fresh
        elif closed:
            break
        elif quiet % _QUIET == 0:
            yield b":\n\n"  # finds a browser that has gone
        await asyncio.sleep(1.0 / _RATE)
    yield b"event: over\ndata: {}\n\n"


class _Sent(NamedTuple):
    """What a browser has got of a track.

    Attributes:
        samples: Number of samples of the track that were sent or left out.
        t: Time of the newest one [s].
        value: The newest one, of a track of values.
        every: Thinning of a scanner's readings.
        shown: Number of samples that the browser has.
        gap: Whether the last of these says that the newest sample is too old.
    """

    samples: int = 0
    t: float = math.nan
    value: Any = None
    every: int = 1
    shown: int = 0
    gap: bool = False


class Seen:
    """What one browser has got: what it has of each track, and lines of the log."""

    def __init__(self) -> None:
        self.version = 0
        self._tracks: dict[TrackKey, _Sent] = {}
        self._lines = 0
        self._moments: Sequence[Json] = []

    def message(self, tracks: Tracks, moments: Sequence[Json] = (), about: Json | None = None) -> bytes:
        """JSON of what is new: of each changed track its address, and its times and values from an index on."""
        changed = []
        for key, shown, track in items(tracks):
            before = self._tracks.get(key, _Sent())
            if isinstance(track, Steps | Scans):
                part = self._from_index(key, shown, track, before)
            else:
                part = self._samples(key, shown, track, before, tracks.end)
            if part is not None:
                changed.append(part)
        lines = [log_line(line) for line in tracks.log[self._lines :]]
        self._lines = len(tracks.log)
        message: Json = {"end": round(tracks.end, 3), "log": lines, "tracks": changed}
        if moments != self._moments:
            message["decisive"] = self._moments = moments
        return msgspec.json.encode(message if about is None else {**message, "about": about}, enc_hook=plain)

    def _from_index(self, key: TrackKey, shown: TrackKey, track: Steps | Scans, before: _Sent) -> list[Any] | None:
        """What is new of a track with a newest sample that may be replaced; None if nothing is."""
        newest, every = (track.v[-1], 1) if isinstance(track, Steps) else (None, track.every)
        now = _Sent(len(track.t), track.t[-1], newest, every)
        if now[:2] == before[:2] and newest is before.value:
            return None
        self._tracks[key] = now
        count = before.samples if every == before.every else 0  # else it was thinned
        same = 0 < count <= len(track.t) and track.t[count - 1] == before.t
        same = same and (isinstance(track, Scans) or track.v[count - 1] is before.value)
        first = count if same else max(0, count - 1)
        t = _times(track.t[first:])
        if isinstance(track, Steps):
            return [address(key), first, t, [msgspec.Raw(text(value).encode()) for value in track.v[first:]], 0, 1]
        return [address(shown), first, t, _values(track.rows(first)), track.width, track.ray]

    def _samples(self, key: TrackKey, shown: TrackKey, track: Curve, before: _Sent, end: float) -> list[Any] | None:
        """What is new of a track of numbers, as a step function; None if nothing is."""
        count = len(track.t)
        gap = end > track.stamp(count - 1) + track.max_age + TIME
        if count == before.samples and gap is before.gap:
            return None
        t, rows = samples_shown(track, end, least=shown != key, first=max(0, before.samples - 1))
        if before.samples:  # the first sample is the newest one before
            t, rows = t[1:], rows[1:]
        first = before.shown - before.gap
        self._tracks[key] = _Sent(count, shown=first + len(t), gap=gap)
        return [address(shown), first, _times(t.tolist()), _values(rows), rows.shape[1], 1] if len(t) else None


def _times(t: Sequence[float]) -> list[float]:
    return [round(each, 5) for each in t]


def _values(rows: Numbers) -> list[list[float | str]]:
    return [[shown_number(value, _DIGITS) for value in row] for row in rows.tolist()]
