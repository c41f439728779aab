"""Events on a thread of their own, so that recording never delays a reflex."""

from __future__ import annotations

import queue
import threading

from ..event import Event, EventSink

_DELAY = 0.01
"""How long a first event waits for others [s]: it comes from the midst of what a reflex waits for, and so must not wake
another thread that wants the interpreter."""


class SinkThread:
    """An event sink that hands everything on from one thread, in the order it came; a context manager.

    Whoever emits pays for a queue alone: encoding, compression and the disk wait elsewhere, and the target need not be
    safe under threads. Everything that was emitted before the context is left has reached the target by then.

    Args:
        target: Where events go.
    """

    def __init__(self, target: EventSink) -> None:
        self._target = target
        self._leaving = threading.Event()
        self._queue: queue.SimpleQueue[Event | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="events", daemon=True)
        self._failure: Exception | None = None

    def emit(self, event: Event) -> None:
        """Take one event."""
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
            except Exception as error:  # noqa: BLE001 - the thread's boundary: kept, and raised where it is waited for
                self._failure = self._failure or error
            event = self._queue.get()
