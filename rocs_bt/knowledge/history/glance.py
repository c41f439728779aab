"""Glance: a graph as it was, of which only that is read which is asked for."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from ..readable import Readable, Stamp
from . import lookup
from .history import History, Stretch
from .state import State
from .values import typed

_FEW = 256  # nodes that are looked up one by one; whoever asks for more is given the whole state
_NEVER = Stamp(float("-inf"), 0)


class Glance(Readable):
    """What a history tells of one revision, read when it is asked for, and kept. Safe under threads.

    A question to few nodes reads these alone; after a few hundred the whole state is taken. It reads the file as long
    as that is open.

    Args:
        history: What is read; of a graph that has the history's schema.
        stretch: The part of it.
        revision: The revision.
        whole: Gives the whole state of this revision.
        lock: What the threads that read this history take turns by.

    Attributes:
        agent: Whose knowledge it was.
    """

    def __init__(
        self, history: History, stretch: Stretch, revision: int, whole: Callable[[], State], lock: threading.RLock
    ) -> None:
        self.schema = history.schema
        self.revision = revision
        self.agent = history.agent
        self._history, self._stretch, self._lock, self._take = history, stretch.id, lock, whole
        self._state: State | None = None
        self._rows: dict[str, dict[str, Any] | None] = {}
        self._stamps: dict[str, dict[str, Stamp]] = {}
        self._found: dict[tuple[str, str, bool], dict[str, dict[str, Any]]] = {}

    def whole(self) -> State:
        """All of it; nobody may change it.

        Raises:
            KnowledgeError: It is not kept any more.
        """
        with self._lock:
            if self._state is None:
                self._state = self._take()
            return self._state

    # -- reading ----------------------------------------------------------------------------------------------------

    def held(self) -> AbstractContextManager[Any]:
        return self._look()

    def nodes(self, kind: str | None = None) -> list[str]:
        kinds = None if kind is None else self.schema.families[self.schema.kind(kind).name]
        if self._state is not None:
            return self._state.nodes(kind)
        with self._look() as connection:
            return lookup.names(connection, self._stretch, self.revision, kinds)

    def row(self, node: str) -> Mapping[str, Any] | None:
        if self._state is not None:
            return self._state.row(node)
        try:
            return self._rows[node]
        except KeyError:
            if len(self._rows) >= _FEW:
                return self.whole().row(node)
        with self._look() as connection:
            found = lookup.kind_of(connection, self._stretch, self.revision, node)
            if found is None:
                self._rows[node] = None
                return None
            kind, stamp, in_base = found
            declared = self.schema.kinds[kind].attributes
            born = None if in_base else stamp.revision
            written = lookup.written(connection, self._stretch, self.revision, node, born)
        row = {"kind": kind, **{name: attribute.default for name, attribute in declared.items()}}
        for name, (value, at) in written.items():
            row[name] = typed(value, declared[name])
            stamp = max(stamp, at, key=_revision)
        row["t"], row["revision"] = stamp
        self._stamps[node] = {name: at for name, (_, at) in written.items()}
        self._rows[node] = row
        return row

    def targets(self, source: str, relation: str) -> Mapping[str, Mapping[str, Any]]:
        return self._edges(source, relation, True)

    def sources(self, target: str, relation: str) -> Mapping[str, Mapping[str, Any]]:
        return self._edges(target, relation, False)

    def stamp(self, node: str, attribute: str | None = None) -> Stamp:
        row = self._row(node)
        if attribute is None:
            return Stamp(row["t"], row["revision"])
        self._declares(node, row, attribute)
        stamps = self._stamps.get(node)
        return self.whole().stamp(node, attribute) if stamps is None else stamps.get(attribute, _NEVER)

    # -- steps ------------------------------------------------------------------------------------------------------

    def _edges(self, node: str, relation: str, forward: bool) -> Mapping[str, Mapping[str, Any]]:
        if self._state is not None:
            return self._state.targets(node, relation) if forward else self._state.sources(node, relation)
        key = node, relation, forward
        if key in self._found:
            return self._found[key]
        if len(self._found) >= _FEW:
            self.whole()
            return self._edges(node, relation, forward)
        if relation not in self.schema.relations:
            return {}
        with self._look() as connection:
            found = lookup.edges(connection, self._stretch, self.revision, node, relation, forward)
        declared = self.schema.relations[relation].attributes
        rows = {}
        for end, (attributes, stamp) in found.items():
            values = {name: typed(value, declared.get(name)) for name, value in attributes.items()}
            rows[end] = {**dict.fromkeys(declared), **values, **stamp._asdict()}
        self._found[key] = rows
        return rows

    @contextmanager
    def _look(self) -> Iterator[Any]:
        """One look at the file: all that is read meanwhile fits together."""
        with self._lock, self._history.look(self._stretch, self.revision) as connection:
            yield connection


def _revision(stamp: Stamp) -> int:
    return stamp.revision
