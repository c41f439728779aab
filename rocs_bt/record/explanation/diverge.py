"""First difference of two runs: of their event streams, for `rocs-bt replay`, and of their tracks, for people."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...event import (
    BodyMoved,
    ContactBegan,
    Event,
    FollowerStepped,
    GoalEntered,
    MinClearanceLowered,
    OutcomeDecided,
    RequirementViolated,
    RobotPushed,
    ScriptActed,
    unpack,
)
from ..fold.states import plain_value
from ..fold.track import Curve, Steps
from ..fold.tracks import Tracks

#: Events of the simulated world; a replay has no world and so emits none of these.
WORLD_EVENTS: tuple[type[Event], ...] = (
    BodyMoved,
    ContactBegan,
    MinClearanceLowered,
    RobotPushed,
    ScriptActed,
    GoalEntered,
    RequirementViolated,
    OutcomeDecided,
)

KINDS = {
    "decisions": ("node", "rule", "ticket", "outcome"),
    "knowledge": ("fact", "board"),
    "commands": ("command",),
    "motion": ("pose",),
}
"""Topics of the tracks that two runs are compared by."""

CLOSE = 0.01
"""Difference from which on two numbers differ, SI units."""

_CONTEXT = 5  # equal events that are kept before the difference
_ALL = 2**31  # maximum number of printed values
_FEW = 6  # the same in short texts
_TEXT = 50  # maximum number of printed characters of a text, for each of these values
_BYTES = msgspec.msgpack.Encoder(order="deterministic").encode  # encodes NaN and infinities, unlike JSON


@dataclass(frozen=True)
class Divergence:
    """First difference of two event streams.

    Attributes:
        index: Number of equal events before the difference.
        expected: Event of the first stream; None if the stream has ended.
        found: Event of the second stream; None if the stream has ended.
        before: Last equal events before the difference, oldest first.
    """

    index: int
    expected: Event | None
    found: Event | None
    before: tuple[Event, ...]

    @property
    def t(self) -> float:
        """Time of the difference [s], taken from the first stream unless it has ended."""
        event = self.expected or self.found
        return event.t if event is not None else 0.0

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the differing fields, if both events are of the same kind."""
        a, b = self.expected, self.found
        if a is None or b is None or type(a) is not type(b):
            return ()
        return tuple(f for f in a.__struct_fields__ if _BYTES(getattr(a, f)) != _BYTES(getattr(b, f)))

    def __str__(self) -> str:
        return self.text()

    def text(self, *, everything: bool = False) -> str:
        """Both events, with the equal events before; long lists are shortened unless `everything` is requested."""
        lines = [f"the runs differ at t = {self.t:.3f} s, at event {self.index + 1}:"]
        shown = [("both    ", e) for e in self.before] + [("recorded", self.expected), ("replayed", self.found)]
        lines += [f"  {title}  {describe(e, everything=everything)}" for title, e in shown]
        if self.fields:
            lines.append(f"  differing fields: {', '.join(map(self._difference, self.fields))}")
        return "\n".join(lines)

    def _difference(self, name: str) -> str:
        """Name of a field, with the place and the values of its first difference if it is a list."""
        a, b = _plain(getattr(self.expected, name)), _plain(getattr(self.found, name))
        if not (isinstance(a, (list, tuple)) and isinstance(b, (list, tuple))):
            return name
        if len(a) != len(b):
            return f"{name} (recorded {len(a)} values, replayed {len(b)})"
        at = next(i for i, (x, y) in enumerate(zip(a, b, strict=True)) if _BYTES(x) != _BYTES(y))
        return f"{name} (first at [{at}]: recorded {_text(a[at], 9, _FEW)}, replayed {_text(b[at], 9, _FEW)})"


def compare(expected: Iterable[Event], found: Iterable[Event], *, cut_off: bool = False) -> Divergence | None:
    """First difference of two event streams, ignoring wall-clock fields; None if they are equal.

    Numbers are compared bit by bit, so that NaN equals NaN. Reading stops at the first difference.

    Args:
        expected: First stream, such as the events of a recording.
        found: Second stream, such as the events of a replay.
        cut_off: Whether the first stream may end earlier, as the recording of a killed run does.
    """
    before: deque[Event] = deque(maxlen=_CONTEXT)
    for index, (a, b) in enumerate(zip_longest(expected, found)):
        if a is None and cut_off:
            break
        if a is None or b is None or type(a) is not type(b) or _BYTES(timeless(a)) != _BYTES(timeless(b)):
            return Divergence(index, a, b, tuple(before))
        before.append(a)
    return None


class Difference(NamedTuple):
    """First difference of one kind between two runs.

    Attributes:
        kind: Kind of the difference, of `KINDS`.
        t: Time of the difference [s].
        agent, topic, name: Track that differs.
        a: Value in the first run as plain data, or a list of numbers in SI units; None if there is none.
        b: Value in the second run.
    """

    kind: str
    t: float
    agent: str
    topic: str
    name: str
    a: Any
    b: Any

    def __str__(self) -> str:
        name = f"action #{self.name}" if self.topic == "ticket" else (self.name or self.topic).replace("\n", " ")
        first, second = (_worded(value) for value in (self.a, self.b))
        where = f"First difference of {self.kind} at t = {self.t:.2f} s, {self.agent} {name}"
        return f"{where}: first run {first}, second run {second}."


def first_differences(a: Tracks, b: Tracks) -> list[Difference]:
    """First difference of each kind between two runs, earliest first; the page finds the same (studio/web/second.js).

    A track that only one run has differs from its beginning. Numbers differ from `CLOSE` on.
    """
    found = []
    for kind, topics in KINDS.items():
        keys = dict.fromkeys(key for run in (a, b) for key, track in run.items() if key.topic in topics and track.t)
        times = {key: t for key in keys if (t := _first(a.get(*key), b.get(*key))) is not None}
        if times:
            key = min(times, key=lambda key: times[key])
            found.append(Difference(kind, times[key], *key, *(_at(run.get(*key), times[key]) for run in (a, b))))
    return sorted(found, key=lambda each: each.t)


def _first(a: Steps | Curve | None, b: Steps | Curve | None) -> float | None:
    """First time at which two tracks differ [s]; None if they do not."""
    if a is None or b is None or not a.t or not b.t:
        return next((track.t[0] for track in (a, b) if track is not None and track.t), None)
    times = np.union1d(a.t, b.t)
    if isinstance(a, Curve) and isinstance(b, Curve) and a.width == b.width:
        x, y = (_sampled(track, times) for track in (a, b))
        alike = np.isclose(x, y, rtol=0.0, atol=CLOSE, equal_nan=True).all(axis=1)
        return None if alike.all() else float(times[alike.argmin()])
    return next((t for t in times.tolist() if _at(a, t) != _at(b, t)), None)


def _sampled(curve: Curve, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Samples at times, infinite before the first."""
    rows = np.vstack([np.full(curve.width, -np.inf), curve.rows()])
    return rows[np.searchsorted(curve.t, times, side="right")]


def _at(track: Steps | Curve | None, t: float) -> Any:
    """Value of a track at a time as plain data; None if there is none."""
    if isinstance(track, Curve):
        last = track.last(t)
        return None if last is None else last[1]
    return None if track is None else plain_value(track.at(t))


def _worded(value: Any) -> str:
    if not isinstance(value, dict):
        return "nothing" if value is None else _text(value, 4, _FEW)
    if "phase" in value:
        return "active" if value.get("active") else "latched" if value.get("latched") else "clear"
    return (
        f"{value['action']} {value['state']}"
        if {"action", "state"} <= value.keys()
        else _text(value.get("outcome", value), 4, _FEW)
    )


def timeless(event: Event) -> Event:
    """Copy of an event with its wall-clock fields set to zero."""
    return msgspec.structs.replace(event, solve_time=0.0) if isinstance(event, FollowerStepped) else event


def describe(event: Event | None, *, digits: int = 9, everything: bool = True) -> str:
    """Describe an event in one line: time, agent, kind and fields, with unpacked values.

    Args:
        event: The event; None for the end of a stream.
        digits: Significant digits of numbers.
        everything: Whether long lists are complete; if not, only their first values are included.
    """
    if event is None:
        return "(the end)"
    fields = []
    for name in event.__struct_fields__:
        value = getattr(event, name)
        if name in ("t", "agent") or value in ("", None, {}, b""):
            continue
        fields.append(f"{name}={_text(_plain(value), digits, _ALL if everything else _FEW)}")
    return f"t={event.t:.3f} {event.agent or 'world'} {type(event).__name__} {' '.join(fields)}"


def _plain(value: object) -> object:
    return unpack(value) if isinstance(value, bytes) and len(value) % 8 == 0 else value


def _text(value: object, digits: int, most: int) -> str:
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, (list, tuple)):
        shown = [_text(v, digits, most) for v in value[:most]]
        return f"[{', '.join(shown)}{f', ... {len(value)} values' if len(value) > most else ''}]"
    if isinstance(value, dict):
        shown = [f"{k}: {_text(v, digits, most)}" for k, v in list(value.items())[:most]]
        return f"{{{', '.join(shown)}{f', ... {len(value)} entries' if len(value) > most else ''}}}"
    text = str(value)
    return text if len(text) <= _TEXT * most else f"{text[: _TEXT * most]} ... {len(text)} characters"
