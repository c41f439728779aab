"""What a graph held at one revision: a copy in plain dicts, which changes are applied to."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from typing import Any

from ...errors import KnowledgeError
from ...event import KnowledgeChanged, Value
from ..graph import KnowledgeGraph
from ..readable import Readable, Stamp
from ..schema import SCHEMA, Schema
from . import guess
from .values import plain, typed

_NEVER = Stamp(-math.inf, 0)
Row = dict[str, Any]


class State(Readable):
    """A graph at one revision, which is read as the live one is, and is nobody's but its owner's.

    Stamps tell of the newest change: writing an equal value again renews a time in the live graph, and is no change.
    What the schema does not know (in a file of another project) is added to the state's own.

    Attributes:
        agent: Whose knowledge it is.
        t: When it was so: the time of its newest change [s]; -inf where nothing ever was written.
    """

    def __init__(self, agent: str, schema: Schema = SCHEMA, t: float = -math.inf, revision: int = 0) -> None:
        self.agent = agent
        self.schema = schema
        self.t = t
        self.revision = revision
        self._rows: dict[str, Row] = {}
        self._empty: dict[str, Row] = {}  # by kind, what a node holds that nothing was written to
        self._stamps: dict[str, dict[str, Stamp]] = {}
        self._targets: dict[tuple[str, str], dict[str, Row]] = {}
        self._sources: dict[tuple[str, str], dict[str, Row]] = {}

    @classmethod
    def of(cls, graph: KnowledgeGraph) -> State:
        """A copy of a live graph: exact inside of `graph.held()`.

        Without, writers go on meanwhile, and the copy is exact once the changes since its `revision` are applied.
        """
        state = cls(graph.agent, graph.schema, graph.clock.now(), graph.revision)
        for name in graph.nodes():
            with contextlib.suppress(KnowledgeError):  # it was removed meanwhile
                state._copy_node(graph, name)
        for relation in graph.schema.relations:
            for source in state.nodes():
                for target, row in graph.targets(source, relation).items():
                    state._relate(source, relation, target, dict(row))
        return state

    def copy(self) -> State:
        """Another state that holds the same."""
        state = State(self.agent, self.schema, self.t, self.revision)
        state._rows = {name: row.copy() for name, row in self._rows.items()}
        state._stamps = {name: stamps.copy() for name, stamps in self._stamps.items()}
        # The rows of edges are put in one another's place, and never changed.
        state._targets = {key: rows.copy() for key, rows in self._targets.items()}
        state._sources = {key: rows.copy() for key, rows in self._sources.items()}
        return state

    # -- reading ----------------------------------------------------------------------------------------------------

    def nodes(self, kind: str | None = None) -> list[str]:
        if kind is None:
            return list(self._rows)
        family = self.schema.families[self.schema.kind(kind).name]
        return [name for name, row in self._rows.items() if row["kind"] in family]

    def row(self, node: str) -> Mapping[str, Any] | None:
        return self._rows.get(node)

    def get(self, node: str, attribute: str) -> Any:
        try:
            return self._rows[node][attribute]
        except KeyError:
            return super().get(node, attribute)

    def targets(self, source: str, relation: str) -> Mapping[str, Mapping[str, Any]]:
        return self._targets.get((source, relation), {})

    def sources(self, target: str, relation: str) -> Mapping[str, Mapping[str, Any]]:
        return self._sources.get((target, relation), {})

    def stamp(self, node: str, attribute: str | None = None) -> Stamp:
        row = self._row(node)
        if attribute is None:
            return Stamp(row["t"], row["revision"])
        self._declares(node, row, attribute)
        return self._stamps[node].get(attribute, _NEVER)

    def written(self, node: str) -> Mapping[str, Stamp]:
        """The attributes of a node that ever were written, and when; the others are at their defaults.

        Raises:
            KnowledgeError: No such node; lists what exists.
        """
        self._row(node)
        return self._stamps[node]

    # -- changing ---------------------------------------------------------------------------------------------------

    def apply(self, change: KnowledgeChanged) -> None:
        """Make one change. One that is in the state already changes nothing but its time and revision."""
        stamp = Stamp(change.t, change.revision)
        what, subject, name = change.what, change.subject, change.name
        if what == "attribute":
            self.write(subject, name, change.value, stamp)
        elif what == "node added":
            self.add(subject, name, stamp)
        elif what == "node removed":
            self._rows.pop(subject, None)
            self._stamps.pop(subject, None)
        elif what == "edge removed":
            self._unrelate(subject, name, str(change.value))
        else:
            if what == "edge added":  # it comes last, wherever an older one stood
                self._unrelate(subject, name, str(change.value))
            self.relate(subject, name, str(change.value), change.attributes, stamp)
        self.t, self.revision = stamp

    def add(self, name: str, kind: str, stamp: Stamp) -> None:
        """Put a node that nothing was written to behind all others, in the place of an older one."""
        if kind not in self.schema.kinds:
            self.schema = guess.with_kind(self.schema, kind)
        if kind not in self._empty:
            declared = self.schema.kinds[kind].attributes
            self._empty[kind] = {"kind": kind, **{attribute: a.default for attribute, a in declared.items()}}
        self._rows.pop(name, None)
        row = self._rows[name] = self._empty[kind].copy()
        row["t"], row["revision"] = stamp
        self._stamps[name] = {}

    def write(self, name: str, attribute: str, value: Value, stamp: Stamp) -> None:
        """Write one attribute, as events tell it, of a node that is there."""
        row = self._rows.get(name)
        if row is None:
            return
        declared = self.schema.kinds[row["kind"]].attributes
        if attribute not in declared:
            if value is None:
                return  # which says nothing of its type
            declared = self._declare(row["kind"], attribute, value)
        row[attribute] = typed(value, declared[attribute])
        row["t"], row["revision"] = self._stamps[name][attribute] = stamp

    def relate(self, source: str, relation: str, target: str, attributes: Mapping[str, Value], stamp: Stamp) -> None:
        """Draw an edge, or write all attributes of one; both ends are there."""
        if source not in self._rows or target not in self._rows:
            return
        if relation not in self.schema.relations:
            kinds = self._rows[source]["kind"], self._rows[target]["kind"]
            self.schema = guess.with_relation(self.schema, relation, *kinds)
        declared = self.schema.relations[relation].attributes
        row: Row = dict.fromkeys(declared)
        for name, value in attributes.items():
            if name not in declared and value is not None:
                declared = self._declare_edge(relation, name, value)
            row[name] = typed(value, declared.get(name))
        row["t"], row["revision"] = stamp
        self._relate(source, relation, target, row)

    def renew(self, name: str, stamp: Stamp) -> None:
        """Say when a node was written last, where that was not its newest attribute's time."""
        self._rows[name].update(t=stamp.t, revision=stamp.revision)

    def _relate(self, source: str, relation: str, target: str, row: Row) -> None:
        self._targets.setdefault((source, relation), {})[target] = row
        self._sources.setdefault((target, relation), {})[source] = row

    def _unrelate(self, source: str, relation: str, target: str) -> None:
        for ends, here, there in ((self._targets, source, target), (self._sources, target, source)):
            others = ends.get((here, relation), {})
            if others.pop(there, None) is not None and not others:
                del ends[here, relation]

    def _declare(self, kind: str, attribute: str, value: Value) -> Mapping[str, Any]:
        self.schema = guess.with_attribute(self.schema, kind, attribute, value)
        self._empty.clear()
        for row in self._rows.values():
            if row["kind"] in self.schema.families[kind]:
                row.setdefault(attribute, None)
        return self.schema.kinds[kind].attributes

    def _declare_edge(self, relation: str, attribute: str, value: Value) -> Mapping[str, Any]:
        self.schema = guess.with_edge_attribute(self.schema, relation, attribute, value)
        for row in (row for (_, each), rows in self._targets.items() if each == relation for row in rows.values()):
            row.setdefault(attribute, None)
        return self.schema.relations[relation].attributes

    def _copy_node(self, graph: KnowledgeGraph, name: str) -> None:
        self.add(name, graph.kind(name), graph.stamp(name))
        for attribute in self.schema.kinds[graph.kind(name)].attributes:
            stamp = graph.stamp(name, attribute)
            if stamp.revision > 0:  # else nobody ever wrote it: a default, or a live view
                self.write(name, attribute, plain(graph.get(name, attribute)), stamp)
        self.renew(name, graph.stamp(name))
