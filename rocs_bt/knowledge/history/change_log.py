"""ChangeLog: all changes of one agent's knowledge graph, and the graph's state at any time."""

from __future__ import annotations

import threading
from bisect import bisect_right
from collections import deque
from collections.abc import Iterable
from itertools import islice
from operator import attrgetter

import msgspec

from ...base.errors import KnowledgeError
from ...event import Event, KnowledgeChanged
from .state import GraphState

_TIME, _REVISION = attrgetter("t"), attrgetter("revision")


class ChangeLog:
    """Changes of one agent's knowledge over one run, from a recording, from an export, or of a run that goes on.

    As a sink of the graph's events, the log grows with the graph. Thread-safe.

    Args:
        base: State of the graph before the first of the changes.
        label: Human-readable name of the run.
        changes: Changes after the base state, in order of revision.
        begin: Start time of the run [s]; that of the base state if omitted.
        end: End time of the run [s]; that of the newest change if omitted.
        keep: Maximum number of changes; older ones become part of the base state. None keeps all.

    Attributes:
        agent: Agent that owns the logged knowledge.
    """

    def __init__(
        self,
        base: GraphState,
        label: str = "",
        changes: Iterable[KnowledgeChanged] = (),
        *,
        begin: float | None = None,
        end: float | None = None,
        keep: int | None = None,
    ) -> None:
        self.agent = base.agent
        self.label = label
        self.base = base
        self.changes = deque(changes)
        self._begin, self._end, self._keep = begin, end, keep
        self._newest = base  # state of the newest query, from which later ones start
        self._lock = threading.Lock()

    @property
    def begin(self) -> float:
        """Start time of the run [s]."""
        return max(self.base.t, 0.0) if self._begin is None else self._begin

    @property
    def end(self) -> float:
        """End time of the run [s]."""
        if self._end is not None:
            return self._end
        return self.changes[-1].t if self.changes else self.begin

    def emit(self, event: Event) -> None:
        """Add a change; ignores other events."""
        if not isinstance(event, KnowledgeChanged):
            return
        with self._lock:
            self.changes.append(event)
            if self._keep is not None and len(self.changes) > self._keep:
                self.base.apply(self.changes.popleft())

    def as_of(self, t: float | None = None, *, revision: int | None = None) -> GraphState:
        """State of the graph at a time [s] or after a revision, for reading only; by default the final state.

        Raises:
            KnowledgeError: The time or revision is before the oldest kept state, or the revision is unknown.
        """
        with self._lock:
            known, changes = self._newest if self._newest.revision > self.base.revision else self.base, self.changes
            until = len(changes)
            if t is not None:
                self._check(t >= self.base.t, f"{t:g} s")
                until = bisect_right(changes, t, key=_TIME)
            elif revision is not None:
                newest = changes[-1].revision if changes else self.base.revision
                self._check(self.base.revision <= revision <= newest, f"revision {revision}")
                until = bisect_right(changes, revision, key=_REVISION)
            if until < (begin := bisect_right(changes, known.revision, key=_REVISION)):
                known, begin = self.base, 0
            state = known.copy()
            later = [*islice(changes, begin, until)]
        for change in later:
            state.apply(change)
        self._newest = state
        return state

    def all_changes(self) -> list[KnowledgeChanged]:
        """The whole log as changes that start from an empty graph, in order of time."""
        with self._lock:
            moment = {"t": max(self.base.t, 0.0), "revision": self.base.revision}
            return [*(msgspec.structs.replace(c, **moment) for c in self.base.changes()), *self.changes]

    def _check(self, kept: bool, requested: str) -> None:
        if not kept:
            last = self.changes[-1] if self.changes else self.base
            raise KnowledgeError(
                f"there is no {requested}: what is known of {self.agent}{self.label and f' in {self.label!r}'} begins "
                f"at {self.begin:g} s, revision {self.base.revision}, and ends at {last.t:g} s, revision "
                f"{last.revision}. Earlier states are not kept."
            )
