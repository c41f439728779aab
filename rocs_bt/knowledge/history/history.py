"""History: what was known when, read from a journal's file."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from ...errors import InputError, KnowledgeError, RecordingError, unknown
from ...event import KnowledgeChanged
from ..schema import SCHEMA, Schema
from . import lookup, reader
from .file import open_to_read
from .reader import Written
from .state import State
from .values import typed


@dataclass(frozen=True)
class Stretch:
    """An unbroken part of a history, from its base to its newest change; revisions count from the graph's beginning.

    Attributes:
        id: Its number in the file.
        first: The base's revision: the oldest state that is known.
        begin: When that was so [s].
        last: The newest change's revision.
        end: When that was made [s].
    """

    id: int
    first: int
    begin: float
    last: int
    end: float


@dataclass(frozen=True)
class RunEntry:
    """One run in a file: its number, whose knowledge it was, and what people call it."""

    number: int
    agent: str
    label: str


class History:
    """What one agent knew over one run; a context manager.

    Args:
        path: The file that a `Journal` wrote, or still writes.
        agent: Whose; may be left out where the run has only one.
        run: The run's number; the newest of that agent if left out.
        schema: What gives values their types; of the project that wrote it.

    Attributes:
        entry: The run that is told of.
        stretches: The unbroken parts, oldest first; where there are several, changes between them were left out.

    Raises:
        RecordingError: There is no such file, or it is damaged.
        InputError: No such agent or run; lists what exists.
    """

    def __init__(
        self, path: Path | str, agent: str | None = None, run: int | None = None, schema: Schema = SCHEMA
    ) -> None:
        self.path = Path(path)
        self.schema = schema
        self._connection = open_to_read(self.path)
        try:
            self.entry = self._chosen(agent, run)
            self.stretches: tuple[Stretch, ...] = ()
            self.refresh()
        except (InputError, RecordingError):
            self._connection.close()
            raise

    @staticmethod
    def runs(path: Path | str) -> list[RunEntry]:
        """All runs in a file, of all agents, the oldest first.

        Raises:
            RecordingError: There is no such file, or it is damaged.
        """
        connection = open_to_read(Path(path))
        try:
            with _reading(Path(path)):
                return [RunEntry(*row) for row in reader.runs(connection)]
        finally:
            connection.close()

    @property
    def agent(self) -> str:
        """Whose knowledge it was."""
        return self.entry.agent

    @property
    def first(self) -> Stretch:
        """The oldest part."""
        return self.stretches[0]

    @property
    def last(self) -> Stretch:
        """The newest part."""
        return self.stretches[-1]

    @property
    def gaps(self) -> list[tuple[int, int]]:
        """Changes that were left out because a queue was full, from and to; what the last one led to is known."""
        return [(a.last + 1, b.first) for a, b in zip(self.stretches, self.stretches[1:], strict=False)]

    def refresh(self) -> None:
        """Look at what was written since: what is known of a journal that is still written."""
        with _reading(self.path):
            rows = reader.stretches(self._connection, self.entry.number, self.entry.agent)
            self.stretches = tuple(Stretch(*row) for row in rows)

    def as_of(self, t: float | None = None, *, revision: int | None = None, since: State | None = None) -> State:
        """What was known at a time [s], or after a revision; at the end where neither is given.

        Args:
            t: The time [s].
            revision: The revision.
            since: An earlier answer, which is left as it is: only changes after it are looked at, which is quicker.

        Raises:
            KnowledgeError: It was before what the file holds, or in a gap.
        """
        stretch, until = self.place(t, revision)
        with self.look(stretch.id, until) as connection:
            if since is not None and stretch.first <= since.revision <= until:
                state = since.copy()
            else:
                state = reader.base(connection, stretch.id, self.agent, self.schema)
            reader.replay(connection, stretch.id, state, until)
        return state

    @contextmanager
    def look(self, stretch: int, until: int) -> Iterator[sqlite3.Connection]:
        """One look at the file, for what was known after a revision of a stretch.

        Raises:
            KnowledgeError: A journal that is still written has folded it meanwhile.
        """
        with _reading(self.path), reader.still(self._connection):
            first = lookup.first_revision(self._connection, stretch)
            if first is None or first > until:
                raise KnowledgeError(f"revision {until} of '{self.path}' is not kept any more; refresh() and ask anew.")
            yield self._connection

    def changes(
        self, since: int = 0, until: int | None = None, *, node: str | None = None, name: str | None = None
    ) -> Iterator[KnowledgeChanged]:
        """Changes in their order; what a base holds is not told as changes.

        Args:
            since: After this revision.
            until: Up to this revision; the newest if left out.
            node: Only about this node, or edges that start from it.
            name: Only of this attribute, relation or kind.
        """
        for stretch in self.stretches:
            last = stretch.last if until is None else min(until, stretch.last)
            with _reading(self.path):
                found = list(reader.changes(self._connection, stretch.id, self.agent, since, last, node, name))
            yield from found

    def value(self, node: str, attribute: str, t: float | None = None, *, revision: int | None = None) -> Any:
        """What one attribute was at a time [s] or after a revision, without looking at the rest; None if not known.

        Raises:
            KnowledgeError: It was before what the file holds, in a gap, or there was no such node.
        """
        stretch, until = self.place(t, revision)
        with _reading(self.path), reader.still(self._connection):
            found = reader.value(self._connection, stretch.id, until, node, attribute)
            if isinstance(found, Written):
                kind = self.schema.kinds.get(found.kind)
                declared = None if kind is None else kind.attributes.get(attribute)
                return typed(found.value, declared)
        return self.as_of(revision=until).get(node, attribute)  # a default, or what is wrong with the question

    def close(self) -> None:
        """Let go of the file."""
        self._connection.close()

    def __enter__(self) -> History:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # -- steps ------------------------------------------------------------------------------------------------------

    def _chosen(self, agent: str | None, run: int | None) -> RunEntry:
        with _reading(self.path):
            entries = [RunEntry(*row) for row in reader.runs(self._connection)]
        if agent is not None and agent not in (agents := list(dict.fromkeys(e.agent for e in entries))):
            raise InputError(unknown("agent", agent, agents, f"'{self.path}'"))
        entries = [e for e in entries if agent in (None, e.agent)]
        newest = entries[-1].number if entries else None
        found = [e for e in entries if e.number == (newest if run is None else run)]
        if not found:
            there = ", ".join(f"{e.number} ({e.label})" for e in entries) or "none"
            raise InputError(f"there is no run {'' if run is None else run} in '{self.path}'. It has: {there}.")
        if len(found) > 1:
            agents = [e.agent for e in found]
            raise InputError(f"'{self.path}' tells of {', '.join(agents)}. Say whose knowledge you want.")
        return found[0]

    def place(self, t: float | None, revision: int | None = None) -> tuple[Stretch, int]:
        """The part of the history, and the revision in it, of a time [s] or revision; the newest of neither.

        Raises:
            KnowledgeError: It was before what the file holds, or in a gap.
        """
        if t is not None and revision is not None:
            raise KnowledgeError(f"a state is asked for by its time or its revision, found both: {t:g} s, {revision}.")
        if t is not None:
            at = self._since([s for s in self.stretches if s.begin <= t], f"{t:g} s")
            if t > at.end and at is not self.last:
                raise KnowledgeError(self._missing(at, f"{t:g} s"))
            return at, self._newest(at, t)
        if revision is None:
            return self.last, self.last.last
        at = self._since([s for s in self.stretches if s.first <= revision], f"revision {revision}")
        if revision > at.last:
            raise KnowledgeError(self._missing(at, f"revision {revision}"))
        return at, revision

    def _since(self, begun: list[Stretch], asked: str) -> Stretch:
        """The last of the stretches that had begun."""
        if begun:
            return begun[-1]
        raise KnowledgeError(
            f"'{self.path}' was asked for {asked}, and begins at {self.first.begin:g} s, revision {self.first.first}; "
            "what was before is not kept."
        )

    def _missing(self, at: Stretch, asked: str) -> str:
        if at is self.last:
            return f"'{self.path}' was asked for {asked}, and ends at {at.end:g} s, revision {at.last}."
        first, last = next(gap for gap in self.gaps if gap[0] == at.last + 1)
        return (
            f"'{self.path}' was asked for {asked}; revisions {first} to {last} were left out, for more was written "
            "than the disk took."
        )

    def _newest(self, stretch: Stretch, t: float) -> int:
        """The newest revision that is not later: times grow with revisions."""
        low, high = stretch.first, stretch.last
        with _reading(self.path):
            while low < high:
                middle = (low + high + 1) // 2
                earlier = reader.time_of(self._connection, stretch.id, middle) <= t
                low, high = (middle, high) if earlier else (low, middle - 1)
        return low


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    try:
        yield
    except (sqlite3.Error, ValueError, TypeError, LookupError) as error:
        raise RecordingError(f"the knowledge '{path}' is damaged: {error}.") from error
