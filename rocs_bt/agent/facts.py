"""Functions that write the facts of a scenario to an agent's Knowledge graph."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from ..base.errors import Fault, InputError, KnowledgeError, did_you_mean, unknown
from ..base.toml_table import Table
from ..catalog import FactSpec, PlaceSpec
from ..declare import Field, Value, location_of, read_fields, read_key
from ..knowledge import Knowledge, Schema

TO, BOTH_WAYS = "to", "both_ways"
_BOTH = Field(BOTH_WAYS, BOTH_WAYS, bool, (), False, "", Value)


def add_facts(knowledge: Knowledge, facts: Sequence[FactSpec]) -> None:
    """Write facts to the graph: all nodes first, so that a relation can lead to the node of a later fact.

    Raises:
        InputError: Facts violate the schema; the error lists all faults with their lines.
    """
    faults: list[Fault] = []
    with knowledge.graph.locked():
        named = {fact.node for fact in facts}
        writers = [_FactWriter(knowledge, fact, named, faults) for fact in facts]
        for write in (_FactWriter.add, _FactWriter.relate):
            for writer in writers:
                write(writer)
    if faults:
        raise InputError(*faults)


def read_attributes(place: PlaceSpec, schema: Schema) -> dict[str, Any]:
    """Convert the further keys of a place to the attributes that the schema declares for its kind.

    Raises:
        InputError: An attribute is unknown, or a value has another type or unit; the error lists all faults, without
            the scenario's file.
    """
    declared = [of.field(name) for name, of in schema.kinds[place.kind].attributes.items()]
    return read_fields(declared, place.attributes, f"the {place.kind} '{place.name}'")


def check_queries(knowledge: Knowledge, facts: Sequence[FactSpec]) -> None:
    """Check the queries in facts: the guards of strategies and the queries of questions.

    Raises:
        InputError: A text is not a valid query; the error lists all faults with their lines.
    """
    faults: list[Fault] = []
    for fact in facts:
        for key in ("guard", "query"):
            text = fact.attributes.get(key)
            if not isinstance(text, str) or fact.kind not in ("strategy", "question"):
                continue
            try:
                knowledge.query(text)
            except InputError as error:
                faults += (
                    Fault(f"the {key} '{text}': {f.message}", *location_of(fact, key), f.hint) for f in error.faults
                )
    if faults:
        raise InputError(*faults)


class _FactWriter:
    """Writer of one fact of a scenario to the Knowledge graph of an agent."""

    def __init__(self, knowledge: Knowledge, fact: FactSpec, named: Collection[str], faults: list[Fault]) -> None:
        self._graph = knowledge.graph
        self._fact = fact
        self._named = named
        self._keys = list(fact.attributes)
        self._table = fact.attributes.opened()
        self._table.faults = faults
        self._known = True

    def add(self) -> None:
        """Add the fact's node with its attributes, or set attributes of a node that exists."""
        graph, fact, table = self._graph, self._fact, self._table
        kind = fact.kind or (graph.kind(fact.node) if graph.has(fact.node) else "")
        if kind not in graph.schema.kinds:
            self._known = False
            if fact.kind:
                table.adopt("kind", InputError(unknown("kind", kind, graph.schema.kinds, "The schema")))
            else:
                names = graph.nodes()
                hint = f"Give it a kind, or {did_you_mean(fact.node, names, 'Knowledge')}"
                table.fault("node", f"there is no node '{fact.node}' yet.", hint)
            return
        declared = graph.schema.kinds[kind].attributes
        for key in self._keys:
            if key not in declared and key not in graph.schema.relations:
                names = [*declared, *_relations_of(kind, graph.schema)]
                table.fault(key, f"a {kind} has no attribute and no relation '{key}'.", did_you_mean(key, names, "It"))
        values = {key: read_key(declared[key].field(key), table) for key in self._keys if key in declared}
        try:
            if fact.kind:
                graph.add(fact.node, fact.kind, **values)
            else:
                graph.set(fact.node, **values)
        except KnowledgeError as error:
            self._known = graph.has(fact.node)
            table.fault(None, str(error))

    def relate(self) -> None:
        """Add the relations that start at the fact's node."""
        if not self._known:
            return
        for key in self._keys:
            if key in self._graph.schema.relations and key not in self._graph.schema.kinds[self._kind].attributes:
                targets = self._targets(key)
                for i, target in enumerate(targets):
                    self._edge(key, i, target)
                if len(targets) > 1 and self._graph.schema.relation(key).single:
                    self._table.fault(key, f"{key} leads to one node only, found {len(targets)}.")

    @property
    def _kind(self) -> str:
        return self._graph.kind(self._fact.node)

    def _targets(self, relation: str) -> list[Any]:
        value = self._table.data[relation]
        return value if isinstance(value, list) else [value]

    def _edge(self, relation: str, number: int, value: Any) -> None:
        table, source = self._table, self._fact.node
        if isinstance(value, str):
            value = {TO: value}
        if not isinstance(value, dict) or not isinstance(value.get(TO), str):
            table.fault(relation, f"{relation} takes names, or tables with 'to', found {value!r}.")
            return
        edge = Table(table.file, value, (*table.key, relation, number), table.positions)
        edge.faults = table.faults
        declared = self._graph.schema.relation(relation).attributes
        for key in value:
            if key not in declared and key not in (TO, BOTH_WAYS):
                table.fault(relation, f"{relation} has no attribute '{key}'.", did_you_mean(key, declared, "It"))
        if value[TO] in self._named and not self._graph.has(value[TO]):
            return  # the fault of that fact is already reported
        values = {key: read_key(declared[key].field(key), edge) for key in value if key in declared}
        directions = [(source, value[TO]), (value[TO], source)]
        for a, b in directions if read_key(_BOTH, edge) else directions[:1]:
            try:
                self._graph.relate(a, relation, b, **values)
            except KnowledgeError as error:
                table.fault(relation, str(error))
                return


def _relations_of(kind: str, schema: Schema) -> list[str]:
    """Names of the relations that may start at a node of a kind."""
    return [r.name for r in schema.relations.values() if any(schema.is_a(kind, source) for source in r.sources)]
