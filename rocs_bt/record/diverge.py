"""First difference of two runs: of their event streams, for `rocs-bt replay`, and of their tracks, for people."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any, NamedTuple

import msgspec
import numpy as np

from ..event import (
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
from .states import Key
from .track import Curve, Steps
from .tracks import TOPICS, Tracks

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


def compare(
    expected: Iterable[Event],
    found: Iterable[Event],
    *,
    skip: tuple[type[Event], ...] = (),
    cut_off: bool = False,
    context: int = 5,
) -> Divergence | None:
    """First difference of two event streams, ignoring wall-clock fields; None if they are equal.

    Numbers are compared bit by bit, so that NaN equals NaN. Reading stops at the first difference.

    Args:
        expected: First stream, such as the events of a recording.
        found: Second stream, such as the events of a replay.
        skip: Kinds of events to ignore in both: `WORLD_EVENTS` for a replay.
        cut_off: Whether the first stream may end earlier, as the recording of a killed run does.
        context: Number of equal events to keep before the difference.
    """
    before: deque[Event] = deque(maxlen=context)
    pairs = zip_longest(_kept(expected, skip), _kept(found, skip))
    for index, (a, b) in enumerate(pairs):
        if a is None and cut_off:
            break
        if a is None or b is None or type(a) is not type(b) or _BYTES(timeless(a)) != _BYTES(timeless(b)):
            return Divergence(index, a, b, tuple(before))
        before.append(a)
    return None


class Difference(NamedTuple):
    """First difference of two runs.

    Attributes:
        t: Time of the difference [s].
        agent, topic, name: Track that differs.
        a: Value in the first run as plain data, or a list of numbers in SI units; None if there is none.
        b: Value in the second run.
    """

    t: float
    agent: str
    topic: str
    name: str
    a: Any
    b: Any

    def __str__(self) -> str:
        what = " ".join(part for part in (self.agent, self.topic, *self.name.split("\n")) if part)
        values = (_text(value, 4, _FEW) for value in (self.a, self.b))
        return f"First difference at t = {self.t:.3f} s, {what}: {' and '.join(values)}."


def first_difference(a: Tracks, b: Tracks) -> Difference | None:
    """First difference of two runs; None if all of their tracks are equal.

    Of several tracks that differ first at the same time, the one with the first topic in `TOPICS` counts: what was
    sensed is before what was decided.

    Args:
        a: All tracks of the first run.
        b: All tracks of the second run.
    """
    order = {topic: i for i, topic in enumerate(TOPICS)}
    found: list[tuple[float, int, Key]] = []
    for key in dict.fromkeys([*(key for key, _ in a.items()), *(key for key, _ in b.items())]):
        if key.topic != "solve" and (t := _first(a.get(*key), b.get(*key))) is not None:
            found.append((t, order.get(key.topic, len(order)), key))
    if not found:
        return None
    t, _, key = min(found, key=lambda each: each[:2])
    return Difference(t, *key, _at(a.get(*key), t), _at(b.get(*key), t))


def _first(a: Steps | Curve | None, b: Steps | Curve | None) -> float | None:
    """Time of the first change that only one of two tracks has, or that differs in both [s]."""
    if a is None or b is None:
        return next((track.t[0] for track in (a, b) if track is not None and track.t), None)
    both = min(len(a.t), len(b.t))
    same = np.array(a.t[:both]) == np.array(b.t[:both])
    if isinstance(a, Steps) and isinstance(b, Steps):
        same &= np.array([x == y or _BYTES(x) == _BYTES(y) for x, y in zip(a.v[:both], b.v[:both], strict=True)], bool)
    elif isinstance(a, Curve) and isinstance(b, Curve) and a.width == b.width:
        x, y = a.rows()[:both], b.rows()[:both]
        same &= ((x == y) | (np.isnan(x) & np.isnan(y))).all(axis=1)
    else:
        same[:] = False
    i = both if same.all() else int(np.argmin(same))
    times = [track.t[i] for track in (a, b) if i < len(track.t)]
    return min(times, default=None)


def _at(track: Steps | Curve | None, t: float) -> Any:
    """Value of a track at a time as plain data; None if there is none, or if the run has ended."""
    if isinstance(track, Curve):
        last = track.last(t)
        return None if last is None else last[1]
    return None if track is None else msgspec.to_builtins(track.at(t))


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


def _kept(events: Iterable[Event], skip: tuple[type[Event], ...]) -> Iterator[Event]:
    return (e for e in events if not isinstance(e, skip))
