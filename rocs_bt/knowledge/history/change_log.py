"""ChangeLog: all changes of one agent's knowledge graph, and the graph's state at any time."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, NoReturn

import msgspec

from ...base.errors import KnowledgeError
from ...event import KnowledgeChanged
from ..schema import SCHEMA, Schema
from .state import State
from .values import typed

_STATES = 8  # number of cached states, for times that are queried again
_TIME, _REVISION = attrgetter("t"), attrgetter("revision")


@dataclass(frozen=True)
class Stretch:
    """Part of a change log in which no change is missing: a base state and all changes that follow it.

    Attributes:
        base: State of the graph before the first of the changes.
        changes: Changes after the base state, in order of revision; revisions count from the start of the graph.
        id: Number of the stretch in a journal's file.
    """

    base: State
    changes: Sequence[KnowledgeChanged] = ()
    id: int = 0

    @property
    def first(self) -> int:
        """Revision of the base state."""
        return self.base.revision

    @property
    def begin(self) -> float:
        """Time of the base state [s]."""
        return self.base.t

    @property
    def last(self) -> int:
        """Revision of the newest change."""
        return self.changes[-1].revision if self.changes else self.first

    @property
    def end(self) -> float:
        """Time of the newest change [s]."""
        return self.changes[-1].t if self.changes else self.begin


class ChangeLog:
    """Changes of one agent's knowledge over one run, from a journal's file, a recording or an export.

    Not thread-safe.

    Args:
        agent: Agent that owns the logged knowledge.
        label: Human-readable name of the run.
        schema: Types and units of the values.
        stretches: Unbroken parts of the log, oldest first; the changes between two stretches are missing.
        begin: Start time of the run [s]; the start of the first stretch if omitted.
        end: End time of the run [s]; the end of the last stretch if omitted.

    Attributes:
        stretches: Unbroken parts of the log, oldest first.
    """

    def __init__(
        self,
        agent: str,
        label: str,
        schema: Schema = SCHEMA,
        stretches: Sequence[Stretch] = (),
        begin: float | None = None,
        end: float | None = None,
    ) -> None:
        self.agent = agent
        self.label = label
        self.schema = schema
        self.stretches = tuple(stretches)
        self._begin, self._end = begin, end
        self._states: dict[tuple[int, int], State] = {}
        self._indices: dict[tuple[int, int], dict[str, list[int]]] = {}

    @property
    def first(self) -> Stretch:
        """Oldest stretch of the log."""
        return self.stretches[0]

    @property
    def last(self) -> Stretch:
        """Newest stretch of the log."""
        return self.stretches[-1]

    @property
    def begin(self) -> float:
        """Start time of the run [s]."""
        return self.first.begin if self._begin is None else self._begin

    @property
    def end(self) -> float:
        """End time of the run [s]."""
        return self.last.end if self._end is None else self._end

    @property
    def gaps(self) -> list[tuple[int, int]]:
        """First and last revision of each gap in the log; the state after the last missing change is known."""
        return [(a.last + 1, b.first) for a, b in zip(self.stretches, self.stretches[1:], strict=False)]

    def as_of(self, t: float | None = None, *, revision: int | None = None) -> State:
        """State of the graph at a time [s] or after a revision; by default the final state.

        Raises:
            KnowledgeError: The time or revision is before the oldest kept state, or changes there are missing.
        """
        stretch, count = self._find(t, revision)
        until = stretch.changes[count - 1].revision if count else stretch.first
        state = self._states.pop((stretch.id, until), None)
        if state is None:
            earlier = [r for s, r in self._states if s == stretch.id and stretch.first <= r <= until]
            state = (self._states[stretch.id, max(earlier)] if earlier else stretch.base).copy()
            for change in stretch.changes[bisect_right(stretch.changes, state.revision, key=_REVISION) : count]:
                state.apply(change)
        self._states[stretch.id, until] = state
        while len(self._states) > _STATES:
            del self._states[next(iter(self._states))]
        return state.copy()

    def value(self, node: str, attribute: str, t: float | None = None, *, revision: int | None = None) -> Any:
        """Value of one attribute at a time [s] or after a revision, found without building the whole state.

        Raises:
            KnowledgeError: The time or revision is before the oldest kept state or in a gap, or there was no such node.
        """
        stretch, count = self._find(t, revision)
        indices = self._indices_in(stretch).get(node, [])
        kind, found = None, None
        for index in reversed(indices[: bisect_right(indices, count - 1)]):
            change = stretch.changes[index]
            if change.what != "attribute":
                kind = change.name if change.what == "node added" else None
                break
            if found is None and change.name == attribute:
                found = change
        else:
            if stretch.base.has(node):
                if found is None:
                    return stretch.base.get(node, attribute)
                kind = stretch.base.kind(node)
        if found is None or kind is None:  # a default, or an invalid name
            return self.as_of(t, revision=revision).get(node, attribute)
        declared = self.schema.kinds[kind].attributes if kind in self.schema.kinds else {}
        return typed(found.value, declared.get(attribute))

    def changes(
        self, since: int = 0, until: int | None = None, *, node: str | None = None, name: str | None = None
    ) -> Iterator[KnowledgeChanged]:
        """Recorded changes in order; nodes and edges of the base states are not included.

        Args:
            since: Revision after which to begin.
            until: Last revision; the newest if omitted.
            node: Changed node to include, with changes of edges that start at it; None for all nodes.
            name: Changed attribute, relation or kind of node to include; None for all.
        """
        for stretch in self.stretches:
            for change in stretch.changes:
                if (
                    since < change.revision <= (stretch.last if until is None else until)
                    and node in (None, change.subject)
                    and name in (None, change.name)
                ):
                    yield change

    def all_changes(self) -> list[KnowledgeChanged]:
        """The whole log as changes that start from an empty graph, in order of time.

        Each base state is expressed by changes at the time of that state. After a gap, changes first remove all earlier
        nodes and edges and then add those of the next base state.
        """
        found: list[KnowledgeChanged] = []
        before = State(self.agent, self.schema)
        for stretch in self.stretches:
            t = max(stretch.begin, 0.0)
            moment = {"t": t, "revision": stretch.first}
            gone = reversed([*before.changes()])
            removed = [c for c in gone if c.what in ("edge added", "node added")]
            found += [
                msgspec.structs.replace(c, what=c.what.replace("added", "removed"), attributes={}, **moment)
                for c in removed
            ]
            found += [msgspec.structs.replace(c, **moment) for c in stretch.base.changes()]
            found += stretch.changes
            if stretch is not self.last:
                before = self.as_of(revision=stretch.last)
        return found

    # -- internal steps ---------------------------------------------------------------------------------------------

    def _find(self, t: float | None, revision: int | None) -> tuple[Stretch, int]:
        """Stretch that contains a time [s] or a revision, and the number of its changes up to that time or revision."""
        if t is not None and revision is not None:
            raise KnowledgeError(f"a state has a time or a revision, found both: {t:g} s and revision {revision}.")
        if t is not None:
            begun = [s for s in self.stretches if s.begin <= t]
            if not begun or (t > begun[-1].end and begun[-1] is not self.last):
                self._missing(begun, f"{t:g} s")
            return begun[-1], bisect_right(begun[-1].changes, t, key=_TIME)
        if revision is None:
            return self.last, len(self.last.changes)
        begun = [s for s in self.stretches if s.first <= revision]
        if not begun or revision > begun[-1].last:
            self._missing(begun, f"revision {revision}")
        return begun[-1], bisect_right(begun[-1].changes, revision, key=_REVISION)

    def _missing(self, begun: Sequence[Stretch], requested: str) -> NoReturn:
        if not begun:
            known = f"begins at {self.first.begin:g} s, revision {self.first.first}; earlier states are not kept"
        elif begun[-1] is self.last:
            known = f"ends at {self.last.end:g} s, revision {self.last.last}"
        else:
            first, last = self.gaps[len(begun) - 1]
            known = f"lacks revisions {first} to {last}, which were dropped because the disk was too slow"
        raise KnowledgeError(f"there is no {requested}: what is known of {self.agent} in '{self.label}' {known}.")

    def _indices_in(self, stretch: Stretch) -> dict[str, list[int]]:
        """Indices of each node's changes in `stretch.changes`, by node; computed when first needed."""
        key = stretch.id, len(stretch.changes)
        if key not in self._indices:
            indices: dict[str, list[int]] = {}
            for index, change in enumerate(stretch.changes):
                if not change.what.startswith("edge"):
                    indices.setdefault(change.subject, []).append(index)
            self._indices = {**{k: v for k, v in self._indices.items() if k[0] != stretch.id}, key: indices}
        return self._indices[key]


def log_of(state: State, label: str) -> ChangeLog:
    """Change log that contains a single state and no changes."""
    t = max(state.t, 0.0)
    return ChangeLog(state.agent, label, state.schema, (Stretch(state),), begin=t, end=t)
