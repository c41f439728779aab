"""The knowledge graph: one networkx MultiDiGraph, checked against a schema, safe under threads."""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from ..clock import Clock
from ..errors import KnowledgeError
from ..event import EventSink, KnowledgeChanged, Value
from .attribute import Attribute, Live
from .declaration import Schema, checked, known
from .schema import SCHEMA
from .signals import Array
from .store import Row, Store
from .subscription import Callback, Delivery, SubscriberFailure, Subscribers, Subscription


class Stamp(NamedTuple):
    """When something was written."""

    t: float  # [s]
    revision: int  # of its newest change


class KnowledgeGraph:
    """What one robot knows, as nodes with a kind and typed attributes, and named relations between them.

    A write is checked first, and then made as a whole. Each change has a revision, counted from 1 without a gap, is
    emitted as a `KnowledgeChanged` event in that order, and told to subscribers after the lock is released. Writing
    an equal value again renews its time, and is no change.

    Args:
        clock: Where time is read.
        sink: Where changes are emitted.
        agent: The agent's name, for the events.
        schema: What may be written.
    """

    def __init__(self, clock: Clock, sink: EventSink, agent: str = "", schema: Schema = SCHEMA) -> None:
        self.schema = schema
        self.revision = 0
        self._clock = clock
        self._sink = sink
        self._agent = agent
        self._lock = threading.RLock()
        self._held = 0
        self._store = Store(schema.kinds)
        self._rows = self._store.rows
        self._stamps: dict[str, dict[str, tuple[float, int]]] = {}
        self._subscribers = Subscribers(sink)
        self._live: Callable[[str], Array] | None = None

    # -- reading ----------------------------------------------------------------------------------------------------

    def has(self, node: str) -> bool:
        """Whether there is such a node."""
        return node in self._rows

    def kind(self, node: str) -> str:
        """The kind of a node.

        Raises:
            KnowledgeError: No such node; lists what exists.
        """
        kind: str = self._row(node)["kind"]
        return kind

    def nodes(self, kind: str | None = None) -> list[str]:
        """The names of all nodes, or of those of a kind, in the order in which they were added.

        Raises:
            KnowledgeError: No such kind; lists what exists.
        """
        with self._lock:
            return list(self._rows if kind is None else self._store.by_kind[self.schema.kind(kind).name])

    def get(self, node: str, attribute: str) -> Any:
        """The value of an attribute; None where it is not known.

        Raises:
            KnowledgeError: No such node, or its kind has no such attribute; lists what exists.
        """
        try:
            return self._rows[node][attribute]
        except KeyError:
            with self._lock:
                kind = self.kind(node)
                known(f"attribute of the {kind} '{node}'", attribute, self.schema.kinds[kind].attributes, "It")
                return self._rows[node][attribute]

    def attributes(self, node: str) -> dict[str, Any]:
        """All attributes of a node that are known, at one moment.

        Raises:
            KnowledgeError: No such node; lists what exists.
        """
        with self._lock:
            row = self._row(node)
            return _present(row, self.schema.kinds[row["kind"]].attributes)

    def stamp(self, node: str, attribute: str | None = None) -> Stamp:
        """When a node, or one of its attributes, was written last; (-inf, 0) for never."""
        with self._lock:
            row = self._row(node)
            if attribute is None:
                return Stamp(row["t"], row["revision"])
            self.get(node, attribute)
            return Stamp(*self._stamps[node].get(attribute, (-math.inf, 0)))

    def related(self, source: str, relation: str) -> list[str]:
        """The targets of a node's relation, in the order in which they were related.

        Raises:
            KnowledgeError: No such node or relation; lists what exists.
        """
        targets = self._store.targets.get((source, relation))
        if targets is not None:
            return list(targets)
        self._row(source)
        self.schema.relation(relation)
        return []

    def edge(self, source: str, relation: str, target: str) -> dict[str, Any] | None:
        """The attributes of one edge that are known; None where there is no such edge.

        Raises:
            KnowledgeError: No such node or relation; lists what exists.
        """
        with self._lock:
            self._row(target)
            if target not in self.related(source, relation):
                return None
            return _present(self._store.targets[source, relation][target], self.schema.relation(relation).attributes)

    @property
    def view(self) -> Any:
        """A read-only, live networkx MultiDiGraph with relations as edge keys; under threads use it inside `held`."""
        return self._store.view

    @contextlib.contextmanager
    def held(self) -> Iterator[Any]:
        """Hold the graph still: no other thread writes. Gives the view.

        For an algorithm over the view, or for several writes that belong together; subscribers are told at the end.
        """
        try:
            with self._lock:
                self._held += 1
                try:
                    yield self.view
                finally:
                    self._held -= 1
        finally:
            self._deliver()

    # -- writing ----------------------------------------------------------------------------------------------------

    def add(self, node: str, kind: str, **attributes: Any) -> None:
        """Add a node.

        Raises:
            KnowledgeError: The name is taken, or the schema refuses it; nothing is written.
        """
        with self._lock:
            declared = self.schema.kind(kind).attributes
            if not isinstance(node, str) or not node:
                raise KnowledgeError(f"a node needs a name, found {node!r}.")
            if node in self._rows:
                raise KnowledgeError(f"node '{node}' exists already, of kind {self.kind(node)}; change it with set().")
            values = checked((kind, node), declared, attributes)
            if missing := [n for n, a in declared.items() if a.required and n not in values]:
                raise KnowledgeError(f"{kind} '{node}' needs {', '.join(missing)}; give them when it is added.")
            values.update(self._live_values(declared, values))
            t, given = self._clock.now(), [name for name in attributes if values[name] is not None]
            self._store.add(node, kind, declared, values, t, self.revision + 1 + len(given))
            stamps = self._stamps[node] = {}
            self._change("node added", node, kind, None, t, (kind,))
            for name in given:
                self._change("attribute", node, name, _plain(values[name]), t, (kind,))
                stamps[name] = (t, self.revision)
        self._deliver()

    def set(self, node: str, **attributes: Any) -> None:
        """Write attributes of a node; None for one that is not known any more.

        Raises:
            KnowledgeError: No such node, or the schema refuses one of them; nothing is written.
        """
        with self._lock:
            row = self._row(node)
            kind = row["kind"]
            declared = self.schema.kinds[kind].attributes
            values = checked((kind, node), declared, attributes)
            live = self._live_values(declared, values) if "signal" in values else None
            t = self._clock.now()
            stamps = self._stamps[node]
            changed = []
            for name, value in values.items():
                if row[name] != value:
                    changed.append(name)
                else:
                    stamps[name] = (t, stamps[name][1] if name in stamps else 0)
            if live:
                values.update(live)
            row.write(values, t, self.revision + len(changed) if changed else row["revision"])
            for name in changed:
                self._change("attribute", node, name, _plain(values[name]), t, (kind,))
                stamps[name] = (t, self.revision)
        self._deliver()

    def remove(self, node: str) -> None:
        """Remove a node and all its edges.

        Raises:
            KnowledgeError: No such node; lists what exists.
        """
        with self._lock:
            kind = self.kind(node)
            for source, relation, target in self._store.edges(node):
                self._unrelate(source, relation, target)
            self._store.remove(node)
            del self._stamps[node]
            self._change("node removed", node, kind, None, self._clock.now(), (kind,))
        self._deliver()

    def relate(self, source: str, relation: str, target: str, **attributes: Any) -> None:
        """Draw an edge, or write attributes of one that is there. A `single` relation lets go of its old target.

        Raises:
            KnowledgeError: No such node or relation, kinds that it does not join, or a refused attribute.
        """
        with self._lock:
            declared = self.schema.relation(relation)
            declared.join((source, self.kind(source)), (target, self.kind(target)))
            values = checked((source, relation, target), declared.attributes, attributes)
            t = self._clock.now()
            targets = self._store.targets.get((source, relation), {})
            row = targets.get(target)
            if row is None:
                for old in list(targets) if declared.single else ():
                    self._unrelate(source, relation, old)
                row = self._store.relate((source, relation, target), declared.attributes)
                what = "edge added"
            else:
                what = "edge changed" if any(row[n] != v for n, v in values.items()) else ""
            row.write(values, t, self.revision + 1 if what else row["revision"])
            if what:
                self._edge_change(what, source, relation, target, t, _present(row, declared.attributes))
        self._deliver()

    def unrelate(self, source: str, relation: str, target: str) -> None:
        """Take an edge away.

        Raises:
            KnowledgeError: There is no such edge; lists what the source is related to.
        """
        with self._lock:
            if target not in (there := self.related(source, relation)):
                names = ", ".join(there) or "nothing"
                raise KnowledgeError(f"there is no edge {source} -{relation}-> {target}; it leads to {names}.")
            self._unrelate(source, relation, target)
        self._deliver()

    # -- listening --------------------------------------------------------------------------------------------------

    def subscribe(
        self, callback: Callback, kind: str | None = None, node: str | None = None, relation: str | None = None
    ) -> Subscription:
        """Hear of changes that fit all the filters given; an edge is about both of its ends.

        Callbacks run on the thread of a writer, after its lock is released, in the order of revision and one at a
        time; keep them short. One that raises is detached, kept in `failures`, and reported as an event.

        Raises:
            KnowledgeError: No such kind or relation. A node need not exist yet.
        """
        if kind is not None:
            self.schema.kind(kind)
        if relation is not None:
            self.schema.relation(relation)
        return self._subscribers.add(callback, kind, node, relation)

    @property
    def failures(self) -> tuple[SubscriberFailure, ...]:
        """Every subscriber that raised and was detached."""
        return tuple(self._subscribers.failures)

    def bind(self, live: Callable[[str], Array]) -> None:
        """Give every node that names a signal its live view, now and from now on.

        Args:
            live: Signal name -> its read-only view.

        Raises:
            KnowledgeError: A node names a signal that is not declared.
        """
        with self._lock:
            self._live = live
            for row in self._rows.values():
                values = self._live_values(self.schema.kinds[row["kind"]].attributes, row)
                row.write(values, row["t"], row["revision"])

    # -- steps ------------------------------------------------------------------------------------------------------

    def _row(self, node: str) -> Row:
        try:
            return self._rows[node]
        except KeyError:
            return known("node", node, dict(self._rows), "Knowledge")

    def _live_values(self, declared: Mapping[str, Attribute], values: Mapping[str, Any]) -> dict[str, Array | None]:
        live, signal = self._live, values.get("signal")
        if live is None:
            return {}
        return {n: None if signal is None else live(signal) for n, a in declared.items() if a.type is Live}

    def _unrelate(self, source: str, relation: str, target: str) -> None:
        self._store.unrelate(source, relation, target)
        self._edge_change("edge removed", source, relation, target, self._clock.now(), {})

    def _change(self, what: str, node: str, name: str, value: Value, t: float, kinds: tuple[str, ...]) -> None:
        self.revision += 1
        change = KnowledgeChanged(
            t=t, agent=self._agent, what=what, subject=node, name=name, value=value, revision=self.revision
        )
        self._sink.emit(change)
        if self._subscribers.all:
            self._subscribers.queue(Delivery(change, (node,), kinds))

    def _edge_change(
        self, what: str, source: str, relation: str, target: str, t: float, attributes: dict[str, Any]
    ) -> None:
        self.revision += 1
        change = KnowledgeChanged(
            t=t, agent=self._agent, what=what, subject=source, name=relation, value=target,
            revision=self.revision, attributes={n: _plain(v) for n, v in attributes.items()},
        )  # fmt: skip
        kinds = (self.kind(source), self.kind(target))
        self._sink.emit(change)
        if self._subscribers.all:
            self._subscribers.queue(Delivery(change, (source, target), kinds, relation))

    def _deliver(self) -> None:
        # Inside `held` the lock is still ours, or will be asked for again: whoever leaves it delivers.
        if not self._held:
            self._subscribers.deliver()


def _present(row: Row, declared: Mapping[str, Attribute]) -> dict[str, Any]:
    return {name: row[name] for name in declared if row[name] is not None}


def _plain(value: Any) -> Value:
    if isinstance(value, tuple):
        return list(value)
    plain: Value = value
    return plain
