"""Events of a control period, handed on together: in lockstep recording costs the less for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from ..event import Event, EventSink


class BatchSink(EventSink, Protocol):
    """A sink that takes many events for less than it takes them one by one, and makes the same of them."""

    def take(self, events: Sequence[Event]) -> None:
        """Take events, at least one, in the order they came."""
        ...


class Gathering:
    """Keeps events until they are handed on, all at once; whoever emits pays next to nothing. Not for threads.

    Attributes:
        sinks: Where they go, in this order; what these make of an event is not needed before it is handed on.
    """

    def __init__(self, *sinks: BatchSink) -> None:
        self.sinks = sinks
        self._events: list[Event] = []
        self.emit: Callable[[Event], None] = self._events.append

    def before(self, watch: Callable[[float], bool]) -> Callable[[float], bool]:
        """What is called once a control period, after what came since the last time was handed on."""

        def handing_on(t: float) -> bool:
            self.hand_on()
            return watch(t)

        return handing_on

    def hand_on(self) -> None:
        """Hand on what came since the last time."""
        if self._events:
            events = self._events[:]
            del self._events[: len(events)]  # before: a sink that raises must not be handed them again
            for sink in self.sinks:
                sink.take(events)
