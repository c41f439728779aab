"""The past of a graph whose run goes on."""

from __future__ import annotations

import threading

from ..graph import KnowledgeGraph
from .glance import Glance
from .history import History
from .journal import Journal
from .state import State


class JournalPast:
    """Answers what a graph held earlier in this run, out of its journal; for `Knowledge.past`. Safe under threads.

    It writes what waits first, so the answer is the same however quick the journal's thread is; that takes a disk's
    time, so it is for Plan, and not for a reflex. What is asked of few nodes is looked up; where the whole state is
    needed, states that get later and later build on one another.

    Args:
        journal: What keeps the graph.
        graph: The graph; it is attached.
    """

    def __init__(self, journal: Journal, graph: KnowledgeGraph) -> None:
        self._journal = journal
        self._graph = graph
        self._asking = threading.RLock()
        self._history: History | None = None
        self._newest: State | None = None

    def as_of(self, t: float) -> Glance:
        """The graph as it was at a time [s]; read from the file when it is asked, until `close`.

        Raises:
            KnowledgeError: Nothing is kept of so long ago.
            RecordingError: The file cannot be written, or read.
        """
        with self._asking:
            self._journal.flush()
            if self._history is None:
                self._history = History(self._journal.path, self._graph.agent, schema=self._graph.schema)
            history = self._history
            history.refresh()
            stretch, revision = history.place(t)

            def whole() -> State:
                self._newest = history.as_of(revision=revision, since=self._newest)
                return self._newest

            return Glance(history, stretch, revision, whole, self._asking)

    def close(self) -> None:
        """Let go of the file; asked again, it opens it again."""
        with self._asking:
            if self._history is not None:
                self._history.close()
            self._history = None
