"""The base class of events, and where events go."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable
from typing import Protocol

import msgspec

Value = float | int | str | bool | None | list[float]


class Event(msgspec.Struct, frozen=True, tag_field="event", tag=True, kw_only=True, gc=False):
    """The base of all events. Plain data has no cycles, so Python's collector need not look at them.

    Attributes:
        t: Time since the episode began [s].
        agent: The agent it happened in; empty for the world's own events.
    """

    t: float
    agent: str = ""


def pack(values: Iterable[float]) -> bytes:
    """Float64 values as bytes: exact, with NaN and infinities, which JSON cannot hold."""
    return array("d", values).tobytes()


def unpack(data: bytes) -> list[float]:
    """The values that `pack` made bytes of."""
    values = array("d")
    values.frombytes(data)
    return values.tolist()


class EventSink(Protocol):
    """Where events go. `emit` must be cheap, must not block and must not raise."""

    def emit(self, event: Event) -> None:
        """Take one event."""
        ...


class NullSink:
    """Forgets everything."""

    def emit(self, event: Event) -> None:
        """Forget the event."""


class ListSink:
    """Keeps events in memory, in the order they came."""

    def __init__(self) -> None:
        self.events: list[Event] = []

    def emit(self, event: Event) -> None:
        """Keep the event."""
        self.events.append(event)


class Fanout:
    """Hands each event to several sinks, in their order."""

    def __init__(self, *sinks: EventSink) -> None:
        self.sinks = sinks
        self._emits = [sink.emit for sink in sinks]
        self.emit: Callable[[Event], None] = self._emits[0] if len(sinks) == 1 else self._each

    def _each(self, event: Event) -> None:
        for emit in self._emits:
            emit(event)
