"""RunRecord: passes the events of a run to recorder, metrics, requirements and the caller's sinks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from ..event import Event, EventSink, Fanout
from ..record import Recorder, RunHeader, Summary
from .metrics import Metrics
from .requirements import RequirementWatch
from .summary import Unrecorded, make_summary


class BatchSink(EventSink, Protocol):
    """Sink that can also take several events at once, at lower cost and with the same result."""

    def take(self, events: Sequence[Event]) -> None:
        """Process at least one event, in order of emission."""


class EventBatch:
    """Buffer of events that are forwarded together, once per control period; `emit` is only a list append.

    Not thread-safe.
    """

    def __init__(self, *sinks: BatchSink) -> None:
        self.sinks = sinks
        self._events: list[Event] = []
        self.emit: Callable[[Event], None] = self._events.append

    def flush(self) -> None:
        """Forward the events since the last call."""
        if self._events:
            events = self._events[:]  # a copy, because `emit` is bound to this list
            del self._events[: len(events)]  # first, so that a sink that raises does not get them again
            for sink in self.sinks:
                sink.take(events)


class _Listener:
    """Wrapper of a caller's sink. After an exception the sink receives no more events; agents and recording go on."""

    def __init__(self, sink: EventSink) -> None:
        self.failure: Exception | None = None
        self._take = sink.emit

    def emit(self, event: Event) -> None:
        """Forward one event."""
        if self.failure is None:
            try:
                self._take(event)
            except Exception as error:  # noqa: BLE001 - boundary: `check` raises it outside of the blocks
                self.failure = error


class RunRecord:
    """Event processing of one run: recorder, metrics, requirements and sinks of the caller.

    Args:
        header: Header of the run; bodies, obstacles and places may be missing.
        recorder: Recorder of the events; None without a recording.
        sinks: Further sinks for all events; `check` raises their exceptions.
        batched: Whether events are forwarded once per control period, by `flush`; not for threaded mode.
    """

    def __init__(
        self, header: RunHeader, recorder: Recorder | None, sinks: Sequence[EventSink] = (), *, batched: bool
    ) -> None:
        self._header = header
        self._metrics = Metrics(header)
        self._batch = EventBatch(*([] if recorder is None else [recorder]), self._metrics)
        first = [self._batch] if batched else self._batch.sinks
        self._listeners = [_Listener(sink) for sink in sinks]
        # The watch comes last and emits into `recorded`: a violation is recorded after the event that shows it.
        recorded = Fanout(*first, *self._listeners)
        self._requirements = RequirementWatch(header.requirements, header.agents, recorded)
        self.sink: EventSink = Fanout(*recorded.sinks, self._requirements) if header.requirements else recorded

    def check(self) -> None:
        """Raise the exception of a caller's sink, which ends the run.

        Raises:
            Exception: A sink raised it.
        """
        for listener in self._listeners:
            if listener.failure is not None:
                raise listener.failure

    def flush(self) -> None:
        """Forward all buffered events."""
        self._batch.flush()

    def summary(self, end: float, unrecorded: Unrecorded) -> Summary:
        """The summary, after the last event; see `make_summary`."""
        self._requirements.close()
        self.flush()
        return make_summary(self._header, self._metrics, self._requirements, end, unrecorded)
