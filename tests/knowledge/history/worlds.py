"""Graphs that are written at random, with every type of attribute, and what they held kept by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import Event, EventSink, KnowledgeChanged, ListSink
from rocs_bt.knowledge import SCHEMA, Attribute, KnowledgeGraph, NodeKind, Readable, Relation

ALL = {
    "number": Attribute(float, default=0.25),
    "count": Attribute(int),
    "flag": Attribute(bool),
    "note": Attribute(str),
    "numbers": Attribute(tuple),
    "pose": Attribute(Pose2),
}
WIDE = SCHEMA.extended(
    kinds=[NodeKind("specimen", ALL)],
    relations=[
        Relation("brushes", ("specimen",), ("specimen",), {n: a for n, a in ALL.items() if n != "pose"}),
        Relation("grips", ("specimen",), ("specimen",), single=True),
    ],
)
finite = st.floats(allow_nan=False, allow_infinity=False)
floats = st.floats(allow_nan=False)
texts = st.text(st.characters(exclude_categories=()), max_size=6)  # with halves of surrogate pairs, and NUL
ints = st.integers() | st.sampled_from([2**63, -(2**63) - 1, 2**63 - 1, -(2**63), 10**400])
poses = st.builds(Pose2, finite, finite, finite)
VALUES: dict[str, st.SearchStrategy[Any]] = {
    "number": st.none() | floats,
    "count": st.none() | ints,
    "flag": st.none() | st.booleans(),
    "note": st.none() | texts,
    "numbers": st.none() | st.lists(floats, max_size=4).map(tuple),
    "pose": st.none() | poses,
}
NAMES = st.sampled_from(["a", "größer", "a boat \u26f5"])  # few, so that what is removed comes again
some = st.fixed_dictionaries({}, optional=VALUES)
edge_some = st.fixed_dictionaries({}, optional={n: v for n, v in VALUES.items() if n != "pose"})
Step = tuple[Any, ...]
STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("add"), NAMES, some),
        st.tuples(st.just("set"), NAMES, some),
        st.tuples(st.just("remove"), NAMES),
        st.tuples(st.just("relate"), NAMES, st.sampled_from(["brushes", "grips"]), NAMES, edge_some),
        st.tuples(st.just("unrelate"), NAMES, st.sampled_from(["brushes", "grips"]), NAMES),
        st.tuples(st.just("wait")),
    ),
    max_size=30,
)


class World:
    """A graph, everything it told, and how to take a step that makes sense."""

    def __init__(self) -> None:
        self.clock, self.sink = SimulatedClock(0.05), ListSink()
        self.sinks: list[EventSink] = [self.sink]
        self.graph = KnowledgeGraph(self.clock, self, "R2", WIDE)

    def emit(self, event: Event) -> None:
        for sink in self.sinks:
            sink.emit(event)

    def take(self, step: Step) -> None:
        """One step; one that the graph would refuse is left out."""
        what, *rest = step
        graph = self.graph
        if what == "wait":
            self.clock.advance()
        elif what == "add" and not graph.has(rest[0]):
            graph.add(rest[0], "specimen", **rest[1])
        elif what == "set" and graph.has(rest[0]):
            graph.set(rest[0], **rest[1])
        elif what == "remove" and graph.has(rest[0]):
            graph.remove(rest[0])
        elif what == "relate" and graph.has(rest[0]) and graph.has(rest[2]):
            graph.relate(rest[0], rest[1], rest[2], **({} if rest[1] == "grips" else rest[3]))
        elif what == "unrelate" and graph.has(rest[0]) and rest[2] in graph.related(rest[0], rest[1]):
            graph.unrelate(*rest)

    def changes(self) -> list[KnowledgeChanged]:
        return [e for e in self.sink.events if isinstance(e, KnowledgeChanged)]


def held(graph: Readable) -> dict[str, Any]:
    """All that a graph holds, in plain dicts; the newest times are left to `naive`."""
    nodes = {n: (graph.kind(n), exact(graph.attributes(n))) for n in graph.nodes()}
    edges = {
        (n, r): {t: exact(graph.edge(n, r, t) or {}) for t in graph.related(n, r)}
        for n in graph.nodes()
        for r in graph.schema.relations
        if graph.related(n, r)
    }
    return {"nodes": nodes, "edges": edges, "order": list(nodes)}


def naive(changes: list[KnowledgeChanged], revision: int) -> dict[str, Any]:
    """What the changes up to a revision make, replayed by hand."""
    kinds: dict[str, str] = {}
    values: dict[str, dict[str, Any]] = {}
    edges: dict[tuple[str, str], dict[str, Any]] = {}
    for change in changes:
        if change.revision > revision:
            break
        subject, name, value = change.subject, change.name, change.value
        if change.what == "node added":
            kinds[subject] = name
            declared = WIDE.kinds[name].attributes
            values[subject] = {n: a.default for n, a in declared.items()}
        elif change.what == "attribute":
            values[subject][name] = back(value, WIDE.kinds[kinds[subject]].attributes[name])
        elif change.what == "node removed":
            del kinds[subject], values[subject]
        elif change.what == "edge removed":
            del edges[subject, name][str(value)]
        else:
            types = WIDE.relations[name].attributes
            row = {n: back(v, types[n]) for n, v in change.attributes.items()}
            edges.setdefault((subject, name), {})[str(value)] = exact(row)
    nodes = {n: (k, exact({a: v for a, v in values[n].items() if v is not None})) for n, k in kinds.items()}
    return {"nodes": nodes, "edges": {e: targets for e, targets in edges.items() if targets}, "order": list(nodes)}


def back(value: Any, declared: Attribute) -> Any:
    made: dict[type, Callable[[Any], Any]] = {Pose2: lambda v: Pose2(*v), tuple: tuple}
    return value if value is None else made.get(declared.type, lambda v: v)(value)


def exact(values: dict[str, Any]) -> dict[str, Any]:
    """Values with their types and the signs of their zeros, which `==` does not see."""

    def one(value: Any) -> Any:
        if isinstance(value, tuple):
            return type(value).__name__, tuple(one(v) for v in value)
        sign = math.copysign(1.0, value) if type(value) is float else 1.0
        return type(value).__name__, value, sign

    return {name: one(value) for name, value in values.items()}
