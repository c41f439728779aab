"""Feed of a live page: the tracks of a run that goes on, and what each browser has got of them."""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import Iterable, Sequence
from typing import Any

import msgspec

from ..event import Event
from ..record import RunHeader
from ..record.comparisons import Comparisons
from ..record.states import Key
from ..record.track import Curve, Scans, Steps
from ..record.tracks import Tracks
from .pack import Json, address, head, items, log_line, plain, text
from .requests import Stream

_DIGITS = 5
_RATE = 10.0  # [Hz] of updates of a browser
_QUIET = 50  # updates without a change, after which a comment is sent


class Feed:
    """Thread-safe tracks of one run that goes on: one thread feeds them, and each browser asks for what it lacks.

    Args:
        extra: Further entries of the head.

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
            return seen.message(self._tracks, self.about)


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


class Seen:
    """What one browser has got: the number of samples and the newest one of each track, and lines of the log.

    Attributes:
        version: Version of the feed at the last message.
    """

    def __init__(self) -> None:
        self.version = 0
        self._tracks: dict[Key, tuple[int, float, Any, int]] = {}
        self._lines = 0

    def message(self, tracks: Tracks, about: Json | None = None) -> bytes:
        """JSON of what is new: of each changed track its address, and its times and values from an index on."""
        changed = []
        for key, shown, track in items(tracks):
            if track.t and (new := self._changes(key, track)) is not None:
                changed.append(_part(key, shown, track, new))
        lines = [log_line(line) for line in tracks.log[self._lines :]]
        self._lines = len(tracks.log)
        message: Json = {"end": round(tracks.end, 3), "log": lines, "tracks": changed}
        return msgspec.json.encode(message if about is None else {**message, "about": about}, enc_hook=plain)

    def _changes(self, key: Key, track: Steps | Curve) -> int | None:
        """Index of the first sample that is new; None if there is none. Later messages begin behind the last one."""
        count, last, value, every = self._tracks.get(key, (0, math.nan, None, 1))
        newest = track.v[-1] if isinstance(track, Steps) else None
        now = len(track.t), track.t[-1], newest, track.every if isinstance(track, Scans) else 1
        if now[:2] == (count, last) and newest is value:
            return None
        self._tracks[key] = now
        if now[3] != every:  # thinned
            return 0
        same = 0 < count <= len(track.t) and track.t[count - 1] == last
        same = same and (isinstance(track, Curve) or track.v[count - 1] is value)
        return count if same else max(0, count - 1)


def _part(key: Key, shown: Key, track: Steps | Curve, first: int) -> list[Any]:
    """A track from an index on: address, index, times, values, width, and rays from one value to the next."""
    t = [round(each, 5) for each in track.t[first:]]
    if isinstance(track, Steps):
        return [address(key), first, t, [msgspec.Raw(text(value).encode()) for value in track.v[first:]], 0, 1]
    rows = track.rows(first).tolist()
    width = track.width
    if shown != key:
        width = 1
        rows = [[min((v for v in row if v == v), default=math.nan)] for row in rows]
    values = [[_number(value) for value in row] for row in rows]
    return [address(shown), first, t, values, width, track.ray if isinstance(track, Scans) else 1]


def _number(value: float) -> float | str:
    if math.isfinite(value):
        return float(f"{value:.{_DIGITS}g}")
    return "NaN" if math.isnan(value) else "∞" if value > 0 else "−∞"
