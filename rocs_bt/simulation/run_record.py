"""What is counted while a run goes on: metrics and requirements, over the same events that are recorded."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from ..event import Event, EventSink, Fanout
from ..record import Recorder, RunHeader, Summary
from .metrics import Metrics
from .requirements import RequirementWatch
from .summary import Unrecorded, make_summary


class BatchSink(EventSink, Protocol):
    """A sink that takes many events at less cost than one by one, with the same result."""

    def take(self, events: Sequence[Event]) -> None:
        """Take events, at least one, in the order they came."""
        ...


class EventBatch:
    """Collects events and hands them on together, once per control period; `emit` costs next to nothing.

    Not safe under threads.

    Attributes:
        sinks: Targets, in this order; no result of theirs is needed before the batch is handed on.
    """

    def __init__(self, *sinks: BatchSink) -> None:
        self.sinks = sinks
        self._events: list[Event] = []
        self.emit: Callable[[Event], None] = self._events.append

    def before(self, watch: Callable[[float], bool]) -> Callable[[float], bool]:
        """A function to call once per control period: flushes the batch, then calls `watch`."""

        def flushing(t: float) -> bool:
            self.flush()
            return watch(t)

        return flushing

    def flush(self) -> None:
        """Hand on the events since the last call."""
        if self._events:
            events = self._events[:]
            del self._events[: len(events)]  # before: a sink that raises must not be handed them again
            for sink in self.sinks:
                sink.take(events)


class _Listener:
    """A sink of the caller's. After an exception it gets no more events, so that agents and recording go on."""

    def __init__(self, sink: EventSink) -> None:
        self.failure: Exception | None = None
        self._take = sink.emit

    def emit(self, event: Event) -> None:
        """Hand on one event."""
        if self.failure is None:
            try:
                self._take(event)
            except Exception as error:  # noqa: BLE001 - the boundary: `check` raises it outside of the blocks
                self.failure = error


class RunRecord:
    """Takes the events of one run: recorder, metrics, requirements, and whoever else listens.

    Args:
        header: Header of the run; scenery and bodies do not matter.
        recorder: Writes the events; None if they are not recorded.
        sinks: More sinks for all events; `check` raises what one of them raised.
        batched: Whether events are handed on once a control period, by `before`. Not for threads.

    Attributes:
        sink: Takes the events of the run.
    """

    def __init__(
        self, header: RunHeader, recorder: Recorder | None, sinks: Sequence[EventSink] = (), *, batched: bool
    ) -> None:
        self._header = header
        self._metrics = Metrics((agent.name for agent in header.agents), simulated=header.simulated)
        self._batch = EventBatch(*([] if recorder is None else [recorder]), self._metrics)
        first = [self._batch] if batched else self._batch.sinks
        self._listeners = [_Listener(sink) for sink in sinks]
        recorded = Fanout(*first, *self._listeners)
        self._requirements = RequirementWatch(header.requirements, header.agents, recorded)
        self.sink: EventSink = Fanout(*recorded.sinks, self._requirements) if header.requirements else recorded

    def before(self, watch: Callable[[float], bool]) -> Callable[[float], bool]:
        """Called once a control period: hands on the events of the last one, checks the sinks, then calls `watch`."""

        def checked(t: float) -> bool:
            self.check()
            return watch(t)

        return self._batch.before(checked)

    def check(self) -> None:
        """Raise what a sink raised; the run ends with it.

        Raises:
            Exception: It did.
        """
        for listener in self._listeners:
            if listener.failure is not None:
                raise listener.failure

    def flush(self) -> None:
        """Hand on all events so far."""
        self._batch.flush()

    def summary(self, end: float, unrecorded: Unrecorded) -> Summary:
        """The summary, after the last event; see `make_summary`."""
        self._requirements.close()
        self.flush()
        return make_summary(self._header, self._metrics, self._requirements, end, unrecorded)
