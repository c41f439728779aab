"""Journal: writes every change of knowledge graphs to a file, on its own thread."""

from __future__ import annotations

import sqlite3
import threading
import time
from collections import deque
from pathlib import Path
from types import TracebackType
from typing import TypeAlias

from ...base.errors import RecordingError
from ...event import KnowledgeChanged
from ..graph import KnowledgeGraph
from .file import append, begin_stretch, compact, next_run, open_to_write
from .history import History
from .state import State

KEEP = 100_000
"""Number of changes of one agent that are kept individually; older ones are merged into a base state."""
LIMIT = 1 << 16
"""Maximum number of queued writes of one agent."""
FLUSH = 0.1
"""Time between two flushes [s of wall time]: the most that is lost if the process is killed."""
_RETRIES = 100  # maximum number of waits of 1 ms for a write in progress, when the state is copied again
Part: TypeAlias = tuple[State | None, list[KnowledgeChanged]]  # base (None: no new stretch), changes


class Journal:
    """Stores complete writes of graphs in an SQLite file, in batches; a context manager.

    A write to a graph only adds an entry to a queue; the journal's thread stores queued writes. Every flush is one
    transaction of complete writes, so the process may be killed at any moment. The file is then consistent and lacks at
    most the writes since the last flush.

    A queue becomes full if the disk is stalled or slower than the writers. With `blocking`, which is meant for
    simulation in lockstep, the writer then waits. Otherwise the journal drops changes and counts them in `lost`, so
    that a control loop never waits. Once there is room, the journal copies the whole state of the graph, and the file
    records which revisions are missing.

    Args:
        path: File; a new run is appended if it exists.
        label: Human-readable name of the run, such as `exp1-7`.
        keep: Number of changes of one agent that are kept.
        limit: Maximum number of queued writes of one agent.
        blocking: Whether a writer waits while the queue is full.
        every: Time between two flushes [s of wall time].

    Raises:
        RecordingError: The file cannot be written, or is not a journal of rocs_bt.
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
        """Number of changes that were dropped because a queue was full."""
        return sum(queue.lost for queue in self._queues)

    def attach(self, graph: KnowledgeGraph) -> None:
        """Record a graph: write its present state now, and every later change.

        Raises:
            RecordingError: The file cannot be written.
        """
        with graph.locked():
            queue = _WriterQueue(graph, State.of(graph), self._limit, self._blocking, self._wake)
            graph.write_observers.add(queue.take)
        self._queues = (*self._queues, queue)
        self.flush()

    def flush(self) -> None:
        """Write all queued changes.

        Raises:
            RecordingError: A write failed, now or before.
        """
        self._flush()
        if self._failure is not None:
            raise RecordingError(f"the knowledge '{self.path}' ends early: {self._failure}.") from self._failure

    def close(self) -> None:
        """Write all queued changes, detach the graphs and close the file; further calls have no effect.

        Raises:
            RecordingError: A write failed, now or before; the file holds the changes before it.
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
            except Exception as error:  # noqa: BLE001 - boundary of the thread: kept, and raised by `flush` or `close`
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
        except Exception:  # of any kind: roll back this flush and pass the error on
            connection.close()
            raise


class _WriterQueue:
    """Queue of one graph's writes for the file."""

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
        self._noticed = 0  # value of `lost` for which the state was last copied

    def take(self, written: list[KnowledgeChanged]) -> None:
        """Queue one complete write; called on the thread that writes to the graph, while the graph is locked."""
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
        """Discard all writes from now on, because the file can no longer be written."""
        self._limit, self._ended = 0, True
        self._queue.clear()
        self._room.set()

    def drain(self) -> list[Part]:
        """Take the data to write: queued changes of the present stretch, and a new base state if any were dropped."""
        lost = self.lost
        base, self._base = self._base, None
        changes = self._queued()
        parts: list[Part] = [(base, changes)] if base is not None or changes else []
        if self._gap or lost != self._noticed:
            restarted = self._restart()
            if restarted is not None:
                parts.append((restarted, []))
        return parts

    def _queued(self) -> list[KnowledgeChanged]:
        """Remove all queued changes and return those with consecutive revision numbers.

        A missing revision means that changes were dropped while the queue was full. The changes after it are useless
        and discarded, until `_restart` has copied the whole state of the graph.
        """
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
        """Copy the graph's state while writers continue; None if changes were dropped again, and a retry is needed.

        A copy made without the graph's lock may contain some newer writes and lack others. It becomes exact by applying
        every write since the start of the copy. Applying a write twice is harmless, because a write holds the new
        value.
        """
        lost = self.lost
        base = State.of(self.graph)
        self._last, self._gap = base.revision, False
        until = self.graph.revision
        for _ in range(_RETRIES):
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
    """Earlier states of a graph in a run, read from its journal; for `Knowledge.past`. Thread-safe.

    A query flushes the journal first, so its answer does not depend on the timing of the journal's thread. This takes
    as long as a disk access: use it in Plan, not in reflexes.

    Args:
        journal: Journal of the graph.
        graph: Graph that is attached to the journal.
    """

    def __init__(self, journal: Journal, graph: KnowledgeGraph) -> None:
        self._journal = journal
        self._graph = graph
        self._lock = threading.Lock()
        self._history: History | None = None

    def as_of(self, t: float) -> State:
        """State of the graph at a time [s].

        Raises:
            KnowledgeError: No state is kept for that time.
            RecordingError: The file cannot be written or read.
        """
        with self._lock:
            self._journal.flush()
            if self._history is None:
                self._history = History(self._journal.path, self._graph.agent, schema=self._graph.schema)
            else:
                self._history.refresh()
            return self._history.as_of(t)

    def close(self) -> None:
        """Close the journal's file; a later query opens it again."""
        with self._lock:
            if self._history is not None:
                self._history.close()
            self._history = None


def write_state(path: Path, state: State, label: str = "") -> None:
    """Store a state in a journal's file as a run without changes, for later runs to load.

    Raises:
        RecordingError: The file cannot be written, or is not a journal of rocs_bt.
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
