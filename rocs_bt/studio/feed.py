"""Feed of a live page: the tracks of a run that goes on, and what each browser has got of them."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from typing import Any

import msgspec

from ..event import Event
from ..record import RunHeader
from ..record.comparisons import Comparisons
from ..record.track import Curve, Scans, Steps
from ..record.tracks import Key, Tracks
from .pack import HIDDEN, WIDE, address, head, log_line, plain, text

_DIGITS = 5


class Feed:
    """Thread-safe tracks of one run: one thread feeds them, and a thread for each browser waits for changes."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._tracks: Tracks | None = None
        self._comparisons: Comparisons | None = None
        self._version = 0
        self.closed = False

    def begin(self, header: RunHeader) -> None:
        """Begin with the header of the run."""
        with self._changed:
            self._tracks = Tracks(header)
            self._comparisons = Comparisons(self._tracks)
            self._tell()

    def take(self, events: Sequence[Event]) -> None:
        """Take new events of the run."""
        with self._changed:
            if self._tracks is not None and self._comparisons is not None:
                self._tracks.take(events)
                self._comparisons.update()
                self._tell()

    def close(self) -> None:
        """End the feed: the browsers get what is left."""
        with self._changed:
            if self._comparisons is not None:
                self._comparisons.update(over=True)
            self.closed = True
            self._tell()

    def head(self) -> bytes:
        """JSON of what does not change, for a new browser; `null` before the run begins."""
        with self._changed:
            if self._tracks is None or self._comparisons is None:
                return b"null"
            given = {**head(self._tracks.header), "end": self._tracks.end, "guards": self._comparisons.texts()}
            return msgspec.json.encode(given, enc_hook=plain)

    def fresh(self, seen: Seen, timeout: float) -> bytes | None:
        """JSON of everything that a browser lacks; None if nothing is new within a time [s]."""
        with self._changed:
            new = self._changed.wait_for(lambda: self._version != seen.version or self.closed, timeout)
            if not new or self._tracks is None or self._version == seen.version:
                return None
            seen.version = self._version
            return seen.message(self._tracks)

    def _tell(self) -> None:
        self._version += 1
        self._changed.notify_all()


class Seen:
    """What one browser has got: the number of samples and the newest one of each track, and lines of the log.

    Attributes:
        version: Version of the feed at the last message.
    """

    def __init__(self) -> None:
        self.version = 0
        self._tracks: dict[Key, tuple[int, float, Any, int]] = {}
        self._lines = 0

    def message(self, tracks: Tracks) -> bytes:
        """JSON of what is new: of each changed track its address, and its times and values from an index on."""
        changed = []
        for key, track in tracks.items():
            if key.topic not in HIDDEN and track.t and (new := self._changes(key, track)) is not None:
                changed.append(_part(key, track, new))
        lines = [log_line(line) for line in tracks.log[self._lines :]]
        self._lines = len(tracks.log)
        return msgspec.json.encode({"end": round(tracks.end, 3), "log": lines, "tracks": changed}, enc_hook=plain)

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


def _part(key: Key, track: Steps | Curve, first: int) -> list[Any]:
    """A track from an index on: address, index, times, values, width, and rays from one value to the next."""
    t = [round(each, 3) for each in track.t[first:]]
    if isinstance(track, Steps):
        return [address(key), first, t, [msgspec.Raw(text(value).encode()) for value in track.v[first:]], 0, 1]
    rows = track.rows(first).tolist()
    width = track.width
    if key.topic == "signal" and width > WIDE:
        key, width = Key(key.agent, key.topic, f"min({key.name})"), 1
        rows = [[min((v for v in row if v == v), default=math.nan)] for row in rows]
    shown = [[_number(value) for value in row] for row in rows]
    return [address(key), first, t, shown, width, track.ray if isinstance(track, Scans) else 1]


def _number(value: float) -> float | str:
    if math.isfinite(value):
        return float(f"{value:.{_DIGITS}g}")
    return "NaN" if math.isnan(value) else "∞" if value > 0 else "−∞"
