"""Base class of events, and sinks that receive events."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable
from enum import IntEnum
from typing import Protocol, runtime_checkable

import msgspec

from ..base.errors import RecordingError

Value = float | int | str | bool | None | list[float]


class Level(IntEnum):
    """Importance of an event for people; the numbers are those of `foxglove.Log`."""

    DEBUG = 1
    INFO = 2
    WARNING = 3
    ERROR = 4
    FATAL = 5


class Event(msgspec.Struct, frozen=True, tag_field="event", tag=True, kw_only=True, gc=False):
    """Base class of all events. They contain plain data without cycles, so garbage collection is disabled for them.

    Attributes:
        t: Time since the start of the episode [s].
        agent: Name of the agent that the event is about; empty for events of the world.
    """

    t: float
    agent: str = ""

    @property
    def sentence(self) -> str:
        """The event for people, without its time and agent; empty if it is not for people."""
        return ""

    @property
    def level(self) -> Level:
        """Importance of the sentence."""
        return Level.INFO


def pack(values: Iterable[float]) -> bytes:
    """Pack float64 values into bytes, exactly, including NaN and infinities, which JSON cannot represent."""
    return array("d", values).tobytes()


def unpack(data: bytes | memoryview) -> list[float]:
    """Unpack values that `pack` has packed.

    Raises:
        RecordingError: The data, of a damaged recording, are no whole numbers.
    """
    values = array("d")
    if len(data) % values.itemsize:
        raise RecordingError(f"the recording is damaged: packed values have {len(data)} bytes.")
    values.frombytes(data)
    return values.tolist()


@runtime_checkable
class EventSink(Protocol):
    """Interface of a receiver of events."""

    def emit(self, event: Event) -> None:
        """Receive one event. This must be fast, must not block, and must not raise."""


class NullSink:
    """Sink that discards all events."""

    def emit(self, event: Event) -> None:
        """Discard the event."""


class ListSink:
    """Sink that keeps events in memory, in order of arrival."""

    def __init__(self) -> None:
        self.events: list[Event] = []

    def emit(self, event: Event) -> None:
        """Append the event."""
        self.events.append(event)


class Fanout:
    """Sink that passes each event to several sinks, in order."""

    def __init__(self, *sinks: EventSink) -> None:
        self.sinks = sinks
        self._emits = [sink.emit for sink in sinks]
        self.emit: Callable[[Event], None] = self._emits[0] if len(sinks) == 1 else self._each

    def _each(self, event: Event) -> None:
        for emit in self._emits:
            emit(event)
