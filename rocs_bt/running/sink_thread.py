"""Event sinks: one with a separate thread, so that recording never delays a reflex, and one with a later target."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable

from ..event import Event, EventSink

_DELAY = 0.01
"""Delay before the first event of a burst is processed [s]. Control code has just emitted this event, and a reflex may
depend on it; processing the event at once would compete with control code for the Python interpreter."""


class SinkThread:
    """Event sink that forwards events to a target from one thread, in order; a context manager.

    An emitter only puts the event into a queue. Encoding, compression and disk access happen in the thread, and the
    target need not be thread-safe. Leaving the context waits until all emitted events have reached the target.
    """

    def __init__(self, target: EventSink) -> None:
        self._target = target
        self._leaving = threading.Event()
        self._queue: queue.SimpleQueue[Event | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="events", daemon=True)
        self._failure: Exception | None = None

    def emit(self, event: Event) -> None:
        """Queue one event."""
        self._queue.put(event)

    def __enter__(self) -> SinkThread:
        self._thread.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._leaving.set()
        self._queue.put(None)
        self._thread.join()
        if self._failure is not None:
            raise self._failure

    def _run(self) -> None:
        event = self._queue.get()
        while event is not None:
            if self._queue.empty():
                self._leaving.wait(_DELAY)
            try:
                self._target.emit(event)
            except Exception as error:  # noqa: BLE001 - thread boundary: `__exit__` raises it
                self._failure = self._failure or error
            event = self._queue.get()


class Relay:
    """Event sink with a target that is set later; events before that are buffered."""

    def __init__(self) -> None:
        self._early: list[Event] = []
        self.emit: Callable[[Event], None] = self._early.append

    def open(self, target: EventSink) -> None:
        """Forward the buffered events, and from now on every event directly."""
        for event in self._early:
            target.emit(event)
        self.emit = target.emit
