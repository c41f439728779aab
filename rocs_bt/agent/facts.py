"""Telling an agent what it knows at the start: facts become nodes, attributes and relations of its graph."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from ..catalog import FactSpec
from ..document import Table
from ..errors import Fault, InputError, KnowledgeError, did_you_mean, unknown
from ..geometry import Pose2
from ..knowledge import Attribute, Knowledge, Schema
from ..units import ANGLE, LENGTH

TO, BOTH_WAYS = "to", "both_ways"
POSE = ("x", "y", "yaw")


def add_facts(knowledge: Knowledge, facts: Sequence[FactSpec]) -> None:
    """Put facts into the graph: first all nodes, so that relations may lead to what is told later.

    Raises:
        InputError: The schema refuses something, with every fault at its line.
    """
    faults: list[Fault] = []
    with knowledge.graph.held():
        named = {fact.node for fact in facts}
        tellers = [_Teller(knowledge, fact, named, faults) for fact in facts]
        for tell in (_Teller.add, _Teller.relate):
            for teller in tellers:
                tell(teller)
    if faults:
        raise InputError(*faults)


def check_queries(knowledge: Knowledge, facts: Sequence[FactSpec]) -> None:
    """Hold the guards of strategies, and the questions, against the language of queries, before anybody asks them.

    Raises:
        InputError: One of them is no query, with every fault at its line.
    """
    faults: list[Fault] = []
    for fact in facts:
        for key in ("guard", "query"):
            text = fact.table.data.get(key)
            if not isinstance(text, str) or fact.kind not in ("strategy", "question"):
                continue
            try:
                knowledge.query(text)
            except InputError as error:
                line, column = fact.table.position(key)
                faults += (
                    Fault(f"the {key} '{text}': {f.message}", fact.table.file, line, column, f.hint)
                    for f in error.faults
                )
    if faults:
        raise InputError(*faults)


class _Teller:
    """One fact on its way into the graph."""

    def __init__(self, knowledge: Knowledge, fact: FactSpec, named: Collection[str], faults: list[Fault]) -> None:
        self._graph = knowledge.graph
        self._fact = fact
        self._named = named
        self._keys = [key for key in fact.table.data if key not in FactSpec.KEYS]
        self._table = Table(fact.table.file, fact.table.data, fact.table.key, fact.table.positions)
        self._table.faults = faults
        self._known = True

    def add(self) -> None:
        """Add the node with its attributes, or set those of one that is there."""
        graph, fact, table = self._graph, self._fact, self._table
        kind = fact.kind or (graph.kind(fact.node) if graph.has(fact.node) else "")
        if kind not in graph.schema.kinds:
            self._known = False
            if fact.kind:
                table.adopt("kind", InputError(unknown("kind", kind, graph.schema.kinds, "The schema")))
            else:
                names = graph.nodes()
                hint = f"Give it a kind, or {did_you_mean(fact.node, names, 'Knowledge')}"
                table.fault("node", f"nothing is named '{fact.node}' yet.", hint)
            return
        declared = graph.schema.kinds[kind].attributes
        for key in self._keys:
            if key not in declared and key not in graph.schema.relations:
                names = [*declared, *_relations_of(kind, graph.schema)]
                table.fault(key, f"a {kind} has no attribute and no relation '{key}'.", did_you_mean(key, names, "It"))
        values = {key: _value(table, key, declared[key]) for key in self._keys if key in declared}
        try:
            if fact.kind:
                graph.add(fact.node, fact.kind, **values)
            else:
                graph.set(fact.node, **values)
        except KnowledgeError as error:
            self._known = graph.has(fact.node)
            table.fault(None, str(error))

    def relate(self) -> None:
        """Draw the edges from the node."""
        if not self._known:
            return
        for key in self._keys:
            if key in self._graph.schema.relations and key not in self._graph.schema.kinds[self._kind].attributes:
                targets = self._targets(key)
                for i, target in enumerate(targets):
                    self._edge(key, i, target)
                if len(targets) > 1 and self._graph.schema.relation(key).single:
                    self._table.fault(key, f"{key} leads to one node alone, found {len(targets)}.")

    @property
    def _kind(self) -> str:
        return self._graph.kind(self._fact.node)

    def _targets(self, relation: str) -> list[Any]:
        told = self._table.raw(relation)
        return told if isinstance(told, list) else [told]

    def _edge(self, relation: str, number: int, told: Any) -> None:
        table, source = self._table, self._fact.node
        if isinstance(told, str):
            told = {TO: told}
        if not isinstance(told, dict) or not isinstance(told.get(TO), str):
            table.fault(relation, f"{relation} leads to names, or to tables with 'to', found {told!r}.")
            return
        edge = Table(table.file, told, (*table.key, relation, number), table.positions)
        edge.faults = table.faults
        declared = self._graph.schema.relation(relation).attributes
        for key in told:
            if key not in declared and key not in (TO, BOTH_WAYS):
                table.fault(relation, f"{relation} has no attribute '{key}'.", did_you_mean(key, declared, "It"))
        if told[TO] in self._named and not self._graph.has(told[TO]):
            return  # what is wrong with that fact is told already
        values = {key: _value(edge, key, declared[key]) for key in told if key in declared}
        ways = [(source, told[TO]), (told[TO], source)]
        for a, b in ways if edge.flag(BOTH_WAYS, False) else ways[:1]:
            try:
                self._graph.relate(a, relation, b, **values)
            except KnowledgeError as error:
                table.fault(relation, str(error))
                return


def _relations_of(kind: str, schema: Schema) -> list[str]:
    """The relations that may start from a kind."""
    return [r.name for r in schema.relations.values() if any(schema.is_a(kind, source) for source in r.sources)]


def _value(table: Table, key: str, attribute: Attribute) -> Any:
    """A value of a file as the schema types it; faults are noted, and what is harmless is given."""
    dimension = attribute.dimensions[0]
    if attribute.type is float:
        return table.quantity(key, dimension, high=float("inf"))
    if attribute.type is tuple:
        return tuple(table.quantities(key, dimension))
    if attribute.type is Pose2:
        pose = table.table(key)
        for extra in sorted({*pose.keys()} - {*POSE}):
            table.fault(key, f"a pose has no '{extra}'.", did_you_mean(extra, POSE, "It"))
        return Pose2(pose.quantity("x", LENGTH), pose.quantity("y", LENGTH), pose.quantity("yaw", ANGLE, 0.0))
    return table.raw(key)  # the graph's own check says what it must be
