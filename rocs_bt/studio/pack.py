"""Packing of tracks for the page: columns of whole numbers that deflate well, and a table of texts."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.words import inactive_rule
from ..event import TicketChanged
from ..record import RunHeader
from ..record.explanation.decisive import decisive
from ..record.fold.states import TrackKey, plain_value
from ..record.fold.track import Curve, Scans, Steps
from ..record.fold.tracks import Tracks

Json = dict[str, Any]
Numbers = NDArray[np.float64]

_MOST = 2**30  # maximum whole number of a column
_RESOLUTION = {"pose": 1e-3, "scan": 2e-2, "joints": 1e-3, "follower": 1e-4}  # [m, rad] by topic
TIME, _FINE_TIME = 1e-3, 1e-5  # [s]; fine for changes at any time, as of threads
_LONGEST = 2e4  # [s] run with fine times
WIDE, FEW = 24, 3  # values above which only the least of a signal is shown; the same of distances, which repeat a scan
HIDDEN = ("wheels", "solve", "atomic")  # topics that the page does not show


class Columns:
    """Columns of whole numbers: each as differences of neighbours, with its bytes in planes; equal columns once."""

    def __init__(self) -> None:
        self.planes: list[bytes] = []
        # Count, width, resolution, bytes of a value; the greatest finite one if others are not finite.
        self.about: list[tuple[float, ...]] = []
        self._known: dict[bytes, int] = {}

    def whole(self, values: ArrayLike, resolution: float = 1.0, width: int = 1, *top: int) -> int:
        """Add a column of rows of whole numbers, perhaps with its greatest one; returns its index."""
        rows = np.asarray(values, np.int32).reshape(-1, width)
        steps = np.diff(rows, axis=0, prepend=np.zeros((1, width), np.int32)).astype(np.int32).T.reshape(-1)
        unsigned = ((steps << 1) ^ (steps >> 31)).astype(np.uint32)
        size = max(1, (int(unsigned.max(initial=0)).bit_length() + 7) // 8)
        planes = b"".join(((unsigned >> (8 * i)) & 255).astype(np.uint8).tobytes() for i in range(size))
        key = repr((resolution, width, size, top)).encode() + planes
        if key not in self._known:
            self._known[key] = len(self.about)
            self.about.append((rows.size, width, resolution, size, *top))
            self.planes.append(planes)
        return self._known[key]

    def real(self, values: ArrayLike, resolution: float, width: int = 1) -> int:
        """Add a column of rows of numbers, rounded to a resolution; returns its index."""
        given = np.asarray(values, np.float64)
        whole = np.clip(np.round(given / resolution), -_MOST, _MOST)
        finite = np.isfinite(given)
        if finite.all():
            return self.whole(whole.astype(np.int32), resolution, width)
        top = int(whole[finite].max(initial=0))
        # What is not finite is just above: far above, each change to it would need four bytes.
        for i, other in enumerate((given == np.inf, np.isnan(given), given == -np.inf), 1):
            whole[other] = top + i
        return self.whole(whole.astype(np.int32), resolution, width, top)


def pack(tracks: Tracks, extra: Json) -> bytes:
    """Pack a run: length of the JSON (4 bytes, little-endian), JSON, and columns; deflated as a whole.

    Args:
        tracks: Tracks of the run.
        extra: Further entries of the JSON.
    """
    columns, texts = Columns(), dict[str, int]()
    # Columns that are alike, such as a pose and its measurement, deflate well if they are neighbours.
    alike = sorted(
        items(tracks),
        key=lambda item: (item[0].agent, item[2].width, item[0].name) if isinstance(item[2], Curve) else ("", 0, ""),
    )
    packed = {shown: _packed(columns, texts, key, shown, track, tracks.end) for key, shown, track in alike}
    about = {
        **head(tracks.header),
        "end": round(tracks.end, 3),
        "log": [log_line(line) for line in tracks.log],
        "tracks": [packed[shown] for _, shown, _ in items(tracks)],
        "columns": columns.about,
        "texts": [msgspec.Raw(text.encode()) for text in texts],
        **extra,
    }
    text = msgspec.json.encode(about, enc_hook=plain)
    text += b" " * (-len(text) % 4)
    return zlib.compress(len(text).to_bytes(4, "little") + text + b"".join(columns.planes), 9)


def head(header: RunHeader) -> Json:
    """What does not change while a run goes on."""
    inactive = {
        agent.name: {rule: inactive_rule(rule, [agent.robot], missing) for rule, missing in agent.inactive.items()}
        for agent in header.agents
    }
    return {"header": header, "inactive": inactive}


def items(tracks: Tracks) -> Iterator[tuple[TrackKey, TrackKey, Steps | Curve]]:
    """Tracks that the page shows: key, key on the page, and track; of wide signals only the least value is shown."""
    declared = ((agent.name, signal) for agent in tracks.header.agents for signal in agent.signals)
    distances = {(agent, signal.name) for agent, signal in declared if set(signal.units) == {"m"}}
    for key, track in tracks.items():
        if key.topic in HIDDEN or not track.t:
            continue
        most = FEW if (key.agent, key.name) in distances else WIDE
        wide = key.topic == "signal" and isinstance(track, Curve) and track.width > most
        yield key, key._replace(name=f"min({key.name})") if wide else key, track


def opens_at(tracks: Tracks, outcomes: Mapping[str, str] = {}) -> list[Json]:
    """Decisive moments, at the first of which the page opens; see `decisive`."""
    return [{"t": each.t, "address": address(each.about), "text": each.text} for each in decisive(tracks, outcomes)]


def samples_shown(track: Curve, end: float, *, least: bool, first: int = 0) -> tuple[Numbers, Numbers]:
    """Samples of a track as a step function: without equal neighbours, and with NaN from when a sample is too old.

    Args:
        track: The track.
        end: End of the run so far [s].
        least: Whether only the least value of each sample is shown.
        first: Index of the first sample.

    Returns:
        Times [s], and samples.
    """
    t, rows = np.array(track.t[first:]), track.rows(first)
    if least:
        rows = np.fmin.reduce(rows, axis=1, keepdims=True)
    until = (t if track.stamps is None else np.array(track.stamps[first:])) + track.max_age
    late = np.flatnonzero(np.append(t[1:], end) > until + TIME)
    if len(late):
        t = np.insert(t, late + 1, np.maximum(t, until)[late])
        rows = np.insert(rows, late + 1, np.nan, axis=0)
    return _steps(t, rows)


def _steps(t: Numbers, rows: Numbers) -> tuple[Numbers, Numbers]:
    """Samples without equal neighbours."""
    before, after = rows[:-1], rows[1:]
    differs = ((before != after) & ~(np.isnan(before) & np.isnan(after))).any(axis=1)
    keep = np.concatenate([[True], differs])[: len(t)]
    return t[keep], rows[keep]


def log_line(line: tuple[Any, ...]) -> list[Any]:
    """A line of the log: time, agent, level, text and address of the track."""
    t, agent, level, text, about = line
    return [round(t, 3), agent, int(level), text, "" if about is None else address(about)]


def address(key: TrackKey) -> str:
    """Address of a track on the page."""
    return "|".join(key)


def plain(value: object) -> object:
    """Value for JSON, for what JSON has no form."""
    if isinstance(value, (tuple, set, frozenset)):
        return list(value)
    raise NotImplementedError(f"{type(value).__name__} is no plain value")


def _packed(
    columns: Columns, texts: dict[str, int], key: TrackKey, shown: TrackKey, track: Steps | Curve, end: float
) -> list[Any]:
    """A track: address, kind, columns of times and values or those of each side, width, and step between rays."""
    if isinstance(track, Steps):
        found = [texts.setdefault(text(value), len(texts)) for value in _once(track.v)]
        return [address(key), "text", columns.real(track.t, _resolution(track.t)), columns.whole(found)]
    t, rows = samples_shown(track, end, least=shown != key)
    ray, width = track.ray if isinstance(track, Scans) else 1, rows.shape[1]
    if key.topic == "compare":  # a side is often a signal, or a side of another comparison: such columns are there once
        sides = [_steps(t, side) for side in np.split(rows, width, axis=1)]
        at = [columns.real(t, TIME) for t, _ in sides]
        return [address(shown), "number", at, [columns.real(v, _fine(v)) for _, v in sides], width, ray]
    index = columns.real(rows, _RESOLUTION.get(key.topic) or _fine(rows), width)
    return [address(shown), "number", columns.real(t, TIME), index, width, ray]


def _once(values: Sequence[Any]) -> Iterator[Any]:
    """Values of a track; of a ticket only the first has its parameters, which the others share."""
    for i, value in enumerate(values):
        yield msgspec.structs.replace(value, parameters={}) if i and isinstance(value, TicketChanged) else value


def _resolution(t: Sequence[float]) -> float:
    """Resolution of times [s]."""
    off = np.abs(np.array(t) / TIME - np.round(np.array(t) / TIME)).max(initial=0.0)
    return _FINE_TIME if off > 1e-3 and t[-1] < _LONGEST else TIME


def text(value: object) -> str:
    """JSON of one value of a track."""
    return msgspec.json.encode(plain_value(value), enc_hook=plain).decode()


def _fine(rows: Numbers) -> float:
    """Resolution for values, a power of ten: a thousandth of their range, a ten thousandth if that is above 0.001."""
    finite: Sequence[float] = rows[np.isfinite(rows)].tolist() or [0.0]
    span, most = max(finite) - min(finite), max(map(abs, finite))
    whole = 10.0 ** math.floor(math.log10(max(span, 1e-3 * most, 1e-9)))
    return max(1e-3 * whole, min(1e-2 * whole, 1e-3), most / 2**30)
