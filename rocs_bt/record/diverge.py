"""Do two streams of events say the same? Used by `rocs-bt replay`, and to hold that the same seed is the same run."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import zip_longest

import msgspec

from ..event import (
    Approached,
    BodyMoved,
    Event,
    Followed,
    GoalEntered,
    Judged,
    RequirementViolated,
    Touched,
    unpack,
)

#: What the simulation tells of the world; a replay has no world, so it has none of these.
WORLD_EVENTS: tuple[type[Event], ...] = (BodyMoved, Touched, Approached, GoalEntered, RequirementViolated, Judged)

_BYTES = msgspec.msgpack.Encoder(order="deterministic").encode  # holds NaN and infinities, unlike JSON


@dataclass(frozen=True)
class Divergence:
    """The first place where two streams differ.

    Attributes:
        index: How many events were the same before it.
        expected: What the first stream has there; None at its end.
        found: What the second stream has there; None at its end.
        before: The last events that were the same, oldest first.
    """

    index: int
    expected: Event | None
    found: Event | None
    before: tuple[Event, ...]

    @property
    def t(self) -> float:
        """When it happened [s], by the first stream where it has not ended."""
        event = self.expected or self.found
        return event.t if event is not None else 0.0

    @property
    def fields(self) -> tuple[str, ...]:
        """The fields that differ, where both are events of one kind."""
        a, b = self.expected, self.found
        if a is None or b is None or type(a) is not type(b):
            return ()
        return tuple(f for f in a.__struct_fields__ if _BYTES(getattr(a, f)) != _BYTES(getattr(b, f)))

    def __str__(self) -> str:
        lines = [f"the runs differ at t = {self.t:.3f} s, at event {self.index + 1}:"]
        lines += [f"  both      {describe(e)}" for e in self.before]
        lines.append(f"  recorded  {describe(self.expected)}")
        lines.append(f"  now       {describe(self.found)}")
        if self.fields:
            lines.append(f"  differ in {', '.join(self.fields)}")
        return "\n".join(lines)


def compare(
    expected: Iterable[Event],
    found: Iterable[Event],
    *,
    skip: tuple[type[Event], ...] = (),
    cut_off: bool = False,
    context: int = 5,
) -> Divergence | None:
    """The first difference of two streams, but for wall-time fields; None where they say the same.

    Numbers are compared bit by bit, so that NaN equals NaN. Reading stops at the first difference.

    Args:
        expected: The first stream, such as a recording's.
        found: The second one, such as a replay's.
        skip: Kinds to leave out on both sides: `WORLD_EVENTS` for a replay.
        cut_off: The first stream may end before the second one, as the recording of a killed run does.
        context: How many equal events to keep before the difference.
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


def timeless(event: Event) -> Event:
    """The event without what wall time put into it."""
    return msgspec.structs.replace(event, solve_time=0.0) if isinstance(event, Followed) else event


def describe(event: Event | None) -> str:
    """One line that tells an event: time, agent, kind and fields; packed values as numbers."""
    if event is None:
        return "(the end)"
    told = []
    for name in event.__struct_fields__:
        value = getattr(event, name)
        if name in ("t", "agent") or value in ("", None, {}, b""):
            continue
        if isinstance(value, bytes):
            value = unpack(value) if len(value) % 8 == 0 else value
        told.append(f"{name}={_text(value)}")
    return f"t={event.t:.3f} {event.agent or 'world'} {type(event).__name__} {' '.join(told)}"


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.9g}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_text(v) for v in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k}: {_text(v)}" for k, v in value.items()) + "}"
    return str(value)


def _kept(events: Iterable[Event], skip: tuple[type[Event], ...]) -> Iterator[Event]:
    return (e for e in events if not isinstance(e, skip))
