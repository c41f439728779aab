"""State of a graph at one revision: a copy in plain dicts, to which changes are applied."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from ...base.geometry import Pose2
from ...event import KnowledgeChanged, Value
from ..attribute import Attribute, plain
from ..declaration import NodeKind, Relation
from ..graph import KnowledgeGraph
from ..readable import Readable, Stamp
from ..schema import SCHEMA, Schema

_NEVER = Stamp(-math.inf, 0)
Row = dict[str, Any]


class GraphState(Readable):
    """Graph at one revision, with the same reading interface as the live graph.

    The stamp of a value is the time and revision of its newest change. The live graph also updates the time when an
    equal value is written again, which is not a change. Kinds, attributes and relations that the schema lacks (in a
    file of another project) are added to the schema of this state.

    Attributes:
        agent: Agent that owns this knowledge graph.
        t: Time of the newest change [s]; -inf without any.
    """

    def __init__(self, agent: str, schema: Schema = SCHEMA, t: float = -math.inf, revision: int = 0) -> None:
        self.agent = agent
        self.schema = schema
        self.t = t
        self.revision = revision
        self._rows: dict[str, Row] = {}  # rows are replaced, never changed: copies share them
        self._stamps: dict[str, dict[str, Stamp]] = {}
        self._empty: dict[str, Row] = {}  # by kind, the row of a node before its first write
        self._targets: dict[tuple[str, str], dict[str, Row]] = {}
        self._sources: dict[tuple[str, str], dict[str, Row]] = {}
        self._shares_edges = False  # whether a copy of this state uses the same edge dicts

    @classmethod
    def of(cls, graph: KnowledgeGraph) -> GraphState:
        """A copy of a live graph."""
        with graph.locked():
            state = cls(graph.agent, graph.schema, graph.clock.now(), graph.revision)
            for name in graph.nodes():
                state._copy_node(graph, name)
            for source, relation, target in graph.edges():
                state._relate(source, relation, target, dict(graph.targets(source, relation)[target]))
        return state

    def copy(self) -> GraphState:
        """An equal, independent state; fast, because both share their data until one of them changes it."""
        state = GraphState(self.agent, self.schema, self.t, self.revision)
        state._rows, state._stamps = self._rows.copy(), self._stamps.copy()
        state._targets, state._sources = self._targets, self._sources
        self._shares_edges = state._shares_edges = True
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
        """Stamps of the attributes of a node that have been written; the others have their defaults.

        Raises:
            KnowledgeError: No such node; lists what exists.
        """
        self._row(node)
        return self._stamps[node]

    def changes(self) -> Iterator[KnowledgeChanged]:
        """Changes that build this state from an empty graph, each with its time and revision."""
        for name in self._rows:
            yield self._change("node added", name, self.kind(name), None, self.stamp(name))
            for attribute, stamp in self._stamps[name].items():
                yield self._change("attribute", name, attribute, self.get(name, attribute), stamp)
        for source, relation, target in self.edges():
            row = self.targets(source, relation)[target]
            attributes = {name: plain(value) for name, value in (self.edge(source, relation, target) or {}).items()}
            stamp = Stamp(row["t"], row["revision"])
            yield self._change("edge added", source, relation, target, stamp, attributes)

    # -- changing ---------------------------------------------------------------------------------------------------

    def apply(self, change: KnowledgeChanged) -> None:
        """Apply a change; a change that the state already contains only updates its time and revision."""
        stamp = Stamp(change.t, change.revision)
        what, subject, name = change.what, change.subject, change.name
        if what == "attribute":
            self.write(subject, name, change.value, stamp)
        elif what == "node added":
            self.add(subject, name, stamp)
        elif what == "node removed":
            self._rows.pop(subject, None)
            self._stamps.pop(subject, None)
        else:
            if what != "edge changed":  # an added edge comes last, whatever the position of an older one
                self._unrelate(subject, name, str(change.value))
            if what != "edge removed":
                self.relate(subject, name, str(change.value), change.attributes, stamp)
        self.t, self.revision = stamp

    def add(self, name: str, kind: str, stamp: Stamp) -> None:
        """Add an empty node after all others, replacing an older one of that name."""
        if kind not in self.schema.kinds:
            self.schema = self.schema.extended(kinds=(NodeKind(kind),))
        if kind not in self._empty:
            declared = self.schema.kinds[kind].attributes
            self._empty[kind] = {"kind": kind, **{attribute: a.default for attribute, a in declared.items()}}
        self._rows.pop(name, None)
        self._rows[name] = {**self._empty[kind], "t": stamp.t, "revision": stamp.revision}
        self._stamps[name] = {}

    def write(self, name: str, attribute: str, value: Value, stamp: Stamp) -> None:
        """Write one attribute; the value has the form that events hold. Ignored if there is no such node."""
        row = self._rows.get(name)
        if row is None:
            return
        declared = self.schema.kinds[row["kind"]].attributes
        if attribute not in declared:
            if value is None:
                return  # its type is unknown
            declared = self._declare(row["kind"], attribute, value)
            row = self._rows[name]
        t, revision = max(row["t"], stamp.t), max(row["revision"], stamp.revision)
        self._rows[name] = {**row, attribute: typed(value, declared[attribute]), "t": t, "revision": revision}
        self._stamps[name] = {**self._stamps[name], attribute: stamp}

    def relate(self, source: str, relation: str, target: str, attributes: Mapping[str, Value], stamp: Stamp) -> None:
        """Add an edge, or write all attributes of an existing one; ignored if one of its ends is missing."""
        if source not in self._rows or target not in self._rows:
            return
        if relation not in self.schema.relations:
            ends = (self._rows[source]["kind"],), (self._rows[target]["kind"],)
            self.schema = self.schema.extended(relations=(Relation(relation, *ends),))
        declared = self.schema.relations[relation].attributes
        row: Row = dict.fromkeys(declared)
        for name, value in attributes.items():
            if name not in declared and value is not None:
                declared = self._declare_edge(relation, name, value)
            row[name] = typed(value, declared.get(name))
        row["t"], row["revision"] = stamp
        self._relate(source, relation, target, row)

    # -- internal steps ---------------------------------------------------------------------------------------------

    def _change(
        self, what: str, subject: str, name: str, value: Any, stamp: Stamp, attributes: Mapping[str, Value] = {}
    ) -> KnowledgeChanged:
        return KnowledgeChanged(
            t=stamp.t,
            agent=self.agent,
            what=what,
            subject=subject,
            name=name,
            value=plain(value),
            revision=stamp.revision,
            attributes=attributes,
        )

    def _relate(self, source: str, relation: str, target: str, row: Row) -> None:
        self._own_edges()
        self._targets.setdefault((source, relation), {})[target] = row
        self._sources.setdefault((target, relation), {})[source] = row

    def _unrelate(self, source: str, relation: str, target: str) -> None:
        self._own_edges()
        for ends, here, there in ((self._targets, source, target), (self._sources, target, source)):
            others = ends.get((here, relation), {})
            if others.pop(there, None) is not None and not others:
                del ends[here, relation]

    def _own_edges(self) -> None:
        """Copy the edges if another state shares them."""
        if self._shares_edges:
            self._targets = {key: rows.copy() for key, rows in self._targets.items()}
            self._sources = {key: rows.copy() for key, rows in self._sources.items()}
            self._shares_edges = False

    def _declare(self, kind: str, name: str, value: Value) -> Mapping[str, Any]:
        """Declare an attribute of a kind with the type of a value."""
        self.schema = self.schema.extended(kinds=(NodeKind(kind, {name: _attribute(value)}),))
        self._empty.clear()
        family = self.schema.families[kind]
        for node, row in self._rows.items():
            if row["kind"] in family:
                self._rows[node] = {name: None, **row}
        return self.schema.kinds[kind].attributes

    def _declare_edge(self, relation: str, name: str, value: Value) -> Mapping[str, Any]:
        """Declare an attribute of a relation with the type of a value."""
        declared = replace(self.schema.relation(relation), attributes={name: _attribute(value)})
        self.schema = self.schema.extended(relations=(declared,))
        # Rows are changed in place because both edge indexes hold them; copies that share them may gain the attribute
        # too.
        for row in (row for (_, each), rows in self._targets.items() if each == relation for row in rows.values()):
            row.setdefault(name, None)
        return self.schema.relations[relation].attributes

    def _copy_node(self, graph: KnowledgeGraph, name: str) -> None:
        self.add(name, graph.kind(name), graph.stamp(name))
        for attribute in self.schema.kinds[graph.kind(name)].attributes:
            stamp = graph.stamp(name, attribute)
            if stamp.revision > 0:  # otherwise never written: a default, or a live view
                self.write(name, attribute, plain(graph.get(name, attribute)), stamp)


def _attribute(value: Value) -> Attribute:
    return Attribute(tuple if isinstance(value, list) else type(value))


def typed(value: Value, declared: Attribute | None) -> Any:
    """A value in the type that the graph holds: a Pose2 if the schema declares one, a tuple for any other list."""
    if isinstance(value, list):
        return Pose2(*value) if declared is not None and declared.type is Pose2 and len(value) == 3 else tuple(value)
    return value
