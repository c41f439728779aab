"""Journal: writes every change of knowledge graphs to a file, on a thread of its own."""

from __future__ import annotations

import sqlite3
import threading
import time
from collections import deque
from pathlib import Path
from types import TracebackType
from typing import TypeAlias

from ...errors import RecordingError
from ...event import KnowledgeChanged
from ..graph import KnowledgeGraph
from .file import append, begin_stretch, compact, next_run, open_to_write
from .history import History
from .state import State

KEEP = 100_000
"""Changes of one agent that are kept, each with its time; older ones are folded into the state they led to."""
LIMIT = 1 << 16
"""Writes of one agent that may wait in the queue."""
FLUSH = 0.1
"""Time between two flushes [s of wall time]: what a killed process may miss."""
_PATIENCE = 100  # [ms] for a write that takes long, when the state is taken anew
Part: TypeAlias = tuple[State | None, list[KnowledgeChanged]]  # a new stretch's base, and changes


class Journal:
    """Writes whole writes of graphs to an SQLite file, many at a time; a context manager.

    The writer of a graph pays for one entry in a queue. Every flush is one transaction of whole writes, so that a
    process may be killed at any moment: the file then opens to a state that was, and misses at most the last flush.

    Where a queue is full, because the disk stands still or is slower than the writers, either the writer waits
    (`blocking`, for lockstep, where nobody looks at a wall clock), or changes are left out, counted in `lost`; once
    there is room the state is taken anew and the file says which revisions it misses. So what is known now is always
    right, and a control loop never waits.

    Args:
        path: The file; a new run is added if it exists.
        label: Name of the run for people, such as `exp1-7`.
        keep: Changes of one agent that are kept.
        limit: Writes of one agent that may wait.
        blocking: Whether a writer waits while the queue is full.
        every: Time between two flushes [s of wall time].

    Raises:
        RecordingError: The file cannot be written, or is none of ours.
    """

    def __init__(
        self,
        path: Path,
        label: str = "",
        *,
        keep: int = KEEP,
        limit: int = LIMIT,
        blocking: bool = False,
        every: float = FLUSH,
    ) -> None:
        self.path = path
        self._label, self._keep, self._limit, self._blocking, self._every = label, keep, limit, blocking, every
        self._queues: tuple[_WriterQueue, ...] = ()
        self._connection = open_to_write(path)
        self._writing = threading.Lock()
        self._wake = threading.Event()
        self._closing = False
        self._failure: Exception | None = None
        self._run_number: int | None = None
        self._thread = threading.Thread(target=self._run, name="knowledge journal", daemon=True)
        self._thread.start()

    @property
    def lost(self) -> int:
        """Changes that were left out because a queue was full."""
        return sum(queue.lost for queue in self._queues)

    def attach(self, graph: KnowledgeGraph) -> None:
        """Write the present state of a graph, and every change from now on.

        Raises:
            RecordingError: The file cannot be written.
        """
        with graph.locked():
            queue = _WriterQueue(graph, State.of(graph), self._limit, self._blocking, self._wake)
            graph.write_observers.add(queue.take)
        self._queues = (*self._queues, queue)
        self.flush()

    def flush(self) -> None:
        """Write all changes up to now.

        Raises:
            RecordingError: It could not be written, now or before.
        """
        self._flush()
        if self._failure is not None:
            raise RecordingError(f"the knowledge '{self.path}' ends early: {self._failure}.") from self._failure

    def close(self) -> None:
        """Write what is left, detach the graphs and close the file; a second call does nothing.

        Raises:
            RecordingError: Something could not be written, now or before; the file holds what came before it.
        """
        if self._closing:
            return
        self._closing = True
        for queue in self._queues:
            with queue.graph.locked():
                queue.graph.write_observers.remove(queue.take)
        self._wake.set()
        self._thread.join()
        try:
            self.flush()
        finally:
            self._connection.close()

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _run(self) -> None:
        while not self._closing:
            self._wake.wait(self._every)
            self._wake.clear()
            self._flush()

    def _flush(self) -> None:
        with self._writing:
            if self._failure is not None:
                return
            try:
                self._write()
            except Exception as error:  # noqa: BLE001 - the thread's boundary: kept, and raised where it is waited for
                self._failure = error
                for queue in self._queues:
                    queue.end()

    def _write(self) -> None:
        batches = [(queue, part) for queue in self._queues for part in queue.drain()]
        if not batches:
            return
        connection = self._connection
        connection.execute("BEGIN IMMEDIATE")
        try:
            for queue, (base, changes) in batches:
                if base is not None:
                    self._run_number = self._run_number or next_run(connection)
                    queue.stretch = begin_stretch(connection, self._run_number, self._label, base)
                append(connection, queue.stretch, changes)
                compact(connection, queue.graph.agent, self._keep)
            connection.execute("COMMIT")
        except Exception:  # whatever it is, nothing of this flush is kept, and it goes on
            connection.close()
            raise


class _WriterQueue:
    """Queue of one graph's writes on their way to the file.

    Attributes:
        graph: The graph.
        stretch: Number of their stretch in the file.
        lost: Number of changes that were left out.
    """

    def __init__(self, graph: KnowledgeGraph, base: State, limit: int, blocking: bool, wake: threading.Event) -> None:
        self.graph = graph
        self.stretch = 0
        self.lost = 0
        self._base: State | None = base
        self._last = base.revision
        self._queue: deque[list[KnowledgeChanged]] = deque()
        self._limit, self._blocking, self._wake = limit, blocking, wake
        self._room = threading.Event()
        self._ended = False
        self._gap = False
        self._noticed = 0  # of `lost`

    def take(self, written: list[KnowledgeChanged]) -> None:
        """One whole write, on the writer's thread and under its graph's lock."""
        queue = self._queue
        if len(queue) >= self._limit // 2:
            self._wake.set()
            while self._blocking and len(queue) >= self._limit and not self._ended:
                self._room.clear()
                self._wake.set()
                self._room.wait(FLUSH)
            if len(queue) >= self._limit or self._ended:
                self.lost += len(written)
                return
        queue.append(written)

    def end(self) -> None:
        """Take nothing more: the file failed."""
        self._limit, self._ended = 0, True
        self._queue.clear()
        self._room.set()

    def drain(self) -> list[Part]:
        """What to write: changes of the present stretch, and the base of a new one where changes were left out."""
        lost = self.lost
        base, self._base = self._base, None
        changes = self._taken()
        parts: list[Part] = [(base, changes)] if base is not None or changes else []
        if self._gap or lost != self._noticed:
            restarted = self._restart()
            if restarted is not None:
                parts.append((restarted, []))
        return parts

    def _taken(self) -> list[KnowledgeChanged]:
        """The changes that wait, up to where some are missing; nothing more comes then until `_restart`."""
        changes: list[KnowledgeChanged] = []
        for _ in range(len(self._queue)):
            written = self._queue.popleft()
            self._gap = self._gap or written[0].revision != self._last + 1
            if not self._gap:
                changes += written
                self._last = written[-1].revision
        self._room.set()
        return changes

    def _restart(self) -> State | None:
        """The graph's state now, copied while its writers go on; None where they were too quick, for another time.

        A copy made without the lock may hold some newer writes and miss others; every write since it began makes it
        whole, for a change says what became of a thing, not what was before.
        """
        lost = self.lost
        base = State.of(self.graph)
        self._last, self._gap = base.revision, False
        until = self.graph.revision
        for _ in range(_PATIENCE):
            for _ in range(len(self._queue)):
                for change in self._queue.popleft():
                    if change.revision > base.revision:
                        self._gap = self._gap or change.revision != base.revision + 1
                        base.apply(change)
            if base.revision >= until or self.lost != lost:
                break
            time.sleep(0.001)
        self._last = base.revision
        self._gap = self._gap or base.revision < until or self.lost != lost
        self._noticed = lost
        return None if self._gap else base


class JournalPast:
    """Earlier states of a graph whose run goes on, out of its journal; for `Knowledge.past`. Safe under threads.

    It writes what waits first, so the answer is the same however quick the journal's thread is; that takes a disk's
    time, so it is for Plan, and not for a reflex.

    Args:
        journal: The journal of the graph.
        graph: The graph; it is attached.
    """

    def __init__(self, journal: Journal, graph: KnowledgeGraph) -> None:
        self._journal = journal
        self._graph = graph
        self._lock = threading.Lock()
        self._history: History | None = None

    def as_of(self, t: float) -> State:
        """The graph as it was at a time [s].

        Raises:
            KnowledgeError: Nothing is kept of so long ago.
            RecordingError: The file cannot be written, or read.
        """
        with self._lock:
            self._journal.flush()
            if self._history is None:
                self._history = History(self._journal.path, self._graph.agent, schema=self._graph.schema)
            else:
                self._history.refresh()
            return self._history.as_of(t)

    def close(self) -> None:
        """Close the file; a later query opens it again."""
        with self._lock:
            if self._history is not None:
                self._history.close()
            self._history = None


def write_state(path: Path, state: State, label: str = "") -> None:
    """Write a state into a journal's file as a run without changes: a later run remembers it.

    Raises:
        RecordingError: The file cannot be written, or is none of ours.
    """
    connection = open_to_write(path)
    try:
        connection.execute("BEGIN IMMEDIATE")
        begin_stretch(connection, next_run(connection), label, state)
        compact(connection, state.agent, KEEP)
        connection.execute("COMMIT")
    except sqlite3.Error as error:
        raise RecordingError(f"the knowledge '{path}' cannot be written: {error}.") from error
    finally:
        connection.close()
