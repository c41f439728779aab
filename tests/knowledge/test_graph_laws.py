"""The graph against a model of plain dicts, in whatever order it is written."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import KnowledgeError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import KnowledgeChanged, ListSink
from rocs_bt.knowledge import SCHEMA, KnowledgeGraph

NAMES = st.sampled_from("abcde")
KINDS = st.sampled_from(["robot", "object", "goal", "place"])
RELATIONS = st.sampled_from(["near", "at", "pursues", "connects"])
VALUES = st.none() | st.sampled_from([0.0, 0.5, 1.0])


def edge_of(relation: str, distance: float | None) -> dict[str, Any]:
    """What an edge of the model holds."""
    if relation == "connects":
        return {"open": True}
    return {} if distance is None else {"distance": distance}


class GraphAgainstDicts(RuleBasedStateMachine):
    @initialize()
    def begin(self) -> None:
        self.clock, self.sink = SimulatedClock(0.05), ListSink()
        self.graph = KnowledgeGraph(self.clock, self.sink, "R2")
        self.kinds: dict[str, str] = {}
        self.values: dict[str, dict[str, Any]] = {}
        self.edges: dict[tuple[str, str], dict[str, float | None]] = {}
        self.written: dict[str, float] = {}
        self.heard: list[KnowledgeChanged] = []
        self.graph.subscribe(self.heard.append)

    @rule()
    def time_passes(self) -> None:
        self.clock.advance()

    @rule(node=NAMES, kind=KINDS)
    def add(self, node: str, kind: str) -> None:
        values = {"pose": Pose2(1.0, 2.0)} if kind != "robot" else {}
        if node in self.kinds:
            with pytest.raises(KnowledgeError, match="exists already"):
                self.graph.add(node, kind, **values)
            return
        self.graph.add(node, kind, **values)
        self.kinds[node], self.values[node] = kind, dict(values)
        self.written[node] = self.clock.now()

    @rule(node=NAMES, value=VALUES, attribute=st.sampled_from(["radius", "tolerance", "length"]))
    def set(self, node: str, value: float | None, attribute: str) -> None:
        if node not in self.kinds or attribute not in SCHEMA.kinds[self.kinds[node]].attributes:
            with pytest.raises(KnowledgeError, match=r"no node named|has no attribute"):
                self.graph.set(node, **{attribute: value})
            return
        self.graph.set(node, **{attribute: value})
        self.values[node][attribute] = value
        self.written[node] = self.clock.now()

    @rule(node=NAMES)
    def remove(self, node: str) -> None:
        if node not in self.kinds:
            with pytest.raises(KnowledgeError, match=r"no node named"):
                self.graph.remove(node)
            return
        self.graph.remove(node)
        del self.kinds[node], self.values[node], self.written[node]
        for (source, _), targets in self.edges.items():
            targets.pop(node, None)
            if source == node:
                targets.clear()

    def fits(self, node: str, kinds: tuple[str, ...]) -> bool:
        return node in self.kinds and any(SCHEMA.is_a(self.kinds[node], kind) for kind in kinds)

    @rule(source=NAMES, relation=RELATIONS, goal=NAMES, distance=VALUES)
    def relate(self, source: str, relation: str, goal: str, distance: float | None) -> None:
        declared = SCHEMA.relations[relation]
        given = {"distance": distance} if relation == "near" else {}
        if not self.fits(source, declared.sources) or not self.fits(goal, declared.targets):
            with pytest.raises(KnowledgeError, match=r"no node named|cannot"):
                self.graph.relate(source, relation, goal, **given)
            return
        self.graph.relate(source, relation, goal, **given)
        targets = self.edges.setdefault((source, relation), {})
        if declared.single and goal not in targets:
            targets.clear()
        targets[goal] = distance if given else None

    @rule(source=NAMES, relation=RELATIONS, goal=NAMES)
    def unrelate(self, source: str, relation: str, goal: str) -> None:
        if goal not in self.edges.get((source, relation), {}):
            with pytest.raises(KnowledgeError, match=r"no node named|no edge"):
                self.graph.unrelate(source, relation, goal)
            return
        self.graph.unrelate(source, relation, goal)
        del self.edges[source, relation][goal]

    @invariant()
    def the_nodes_are_the_models(self) -> None:
        assert self.graph.nodes() == list(self.kinds)
        for kind in SCHEMA.kinds:
            assert self.graph.nodes(kind) == [n for n, k in self.kinds.items() if SCHEMA.is_a(k, kind)]
        for node, values in self.values.items():
            defaults = {n: a.default for n, a in SCHEMA.kinds[self.kinds[node]].attributes.items()}
            expected = {n: v for n, v in {**defaults, **values}.items() if v is not None}
            assert self.graph.attributes(node) == expected
            assert self.graph.stamp(node).t == self.written[node]

    @invariant()
    def the_edges_are_the_models(self) -> None:
        expected = {(s, t, r) for (s, r), targets in self.edges.items() for t in targets}
        assert set(self.graph.view.edges) == expected
        for (source, relation), targets in self.edges.items():
            if source in self.kinds:
                assert self.graph.related(source, relation) == list(targets)
            else:
                with pytest.raises(KnowledgeError, match="no node named"):
                    self.graph.related(source, relation)
            for target, distance in targets.items():
                known = edge_of(relation, distance)
                assert self.graph.edge(source, relation, target) == known

    @invariant()
    def no_revision_is_lost_or_told_out_of_order(self) -> None:
        assert [e.revision for e in self.heard] == list(range(1, self.graph.revision + 1))
        assert self.heard == self.sink.events


TestGraphAgainstDicts = GraphAgainstDicts.TestCase
TestGraphAgainstDicts.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
