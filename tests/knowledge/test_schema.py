from __future__ import annotations

import math

import numpy as np
import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import KnowledgeError
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.units import LENGTH, SPEED
from rocs_bt.event import ListSink
from rocs_bt.knowledge import POSE, SCHEMA, Attribute, KnowledgeGraph, Live, NodeKind, Relation, Schema


def graph_of(schema: Schema) -> KnowledgeGraph:
    return KnowledgeGraph(SimulatedClock(0.05), ListSink(), "R2", schema)


@pytest.mark.parametrize("kind", SCHEMA.kinds.values(), ids=lambda k: k.name)
def test_every_kind_can_be_added_with_all_that_it_declares(kind: NodeKind) -> None:
    samples = {float: 0.5, int: 2, bool: True, str: "text", tuple: (1.0, 2.0), Pose2: Pose2(1.0, 2.0, 0.5)}
    values = {
        n: (0.5,) * a.size if a.size else a.choices[0] if a.choices else samples[a.type]
        for n, a in kind.attributes.items()
        if a.type is not Live
    }
    graph = graph_of(SCHEMA)
    graph.add("it", kind.name, **values)
    assert graph.attributes("it") == values
    assert graph.nodes(kind.name) == ["it"]


@pytest.mark.parametrize("relation", SCHEMA.relations.values(), ids=lambda r: r.name)
def test_every_relation_joins_exactly_the_kinds_that_it_declares(relation: Relation) -> None:
    graph = graph_of(SCHEMA)
    for kind in SCHEMA.kinds.values():
        required = {n: "text" if a.type is str else Pose2(0.0, 0.0) for n, a in kind.attributes.items() if a.required}
        graph.add(f"{kind.name} a", kind.name, **required)
        graph.add(f"{kind.name} b", kind.name, **required)
    for source in SCHEMA.kinds:
        for target in SCHEMA.kinds:
            ends = f"{source} a", relation.name, f"{target} b"
            fits = any(SCHEMA.is_a(source, kind) for kind in relation.sources)
            if fits and any(SCHEMA.is_a(target, kind) for kind in relation.targets):
                for other in graph.relating(ends[2], relation.name) if relation.max_sources else ():
                    graph.unrelate(other, *ends[1:])
                graph.relate(*ends)
                assert ends[2] in graph.related(*ends[:2])
            else:
                with pytest.raises(KnowledgeError, match=f"'{relation.name}' cannot"):
                    graph.relate(*ends)


@pytest.mark.parametrize(
    ("attribute", "given", "stored"),
    [
        (Attribute(float), 1, 1.0),
        (Attribute(float), np.float32(0.5), 0.5),
        (Attribute(float), math.inf, math.inf),
        (Attribute(int), np.int64(3), 3),
        (Attribute(bool), False, False),
        (Attribute(tuple), [1, 2.5], (1.0, 2.5)),
        (Attribute(tuple), np.array([1.0]), (1.0,)),
        (Attribute(Pose2, POSE), Pose2(1, 2), Pose2(1.0, 2.0, 0.0)),
        (Attribute(str), None, None),
    ],
)
def test_a_value_is_stored_as_plain_python(attribute: Attribute, given: object, stored: object) -> None:
    checked = attribute.check(given)
    assert checked == stored
    assert type(checked) is type(stored)


@pytest.mark.parametrize(
    ("attribute", "given", "message"),
    [
        (Attribute(float, (LENGTH,)), "0.5 m", r"must be a number \[m\], found '0.5 m'"),
        (Attribute(float), True, "must be a number"),
        (Attribute(float), np.True_, "must be a number"),
        (Attribute(float), math.nan, "found nan"),
        (Attribute(float), 10**400, "too large"),
        (Attribute(float, (SPEED,), low=0.0), -1.0, r"must be a number \[m/s\] in \[0, inf\], found -1.0"),
        (Attribute(float, high=1.0), 1.5, r"in \[-inf, 1\]"),
        (Attribute(int), 1.0, "must be a whole number, found 1.0"),
        (Attribute(int), True, "must be a whole number"),
        (Attribute(int, low=1), 0, r"in \[1, inf\]"),
        (Attribute(bool), 1, "must be True or False"),
        (Attribute(str), 1, "must be a text, found 1"),
        (Attribute(tuple), "12", "must be a list of numbers"),
        (Attribute(tuple), 3.0, "must be a list of numbers"),
        (Attribute(tuple), [1.0, math.nan], "found nan"),
        (Attribute(Pose2, POSE), (1.0, 2.0, 3.0), r"must be a Pose2 \[m, rad\]"),
        (Attribute(Pose2, POSE), Pose2(1.0, math.inf), "must be finite"),
        (Attribute(Pose2, POSE), Pose2(math.nan, 0.0), "must be"),
        (Attribute(float, required=True), None, "must be a number"),
        (Attribute(Live), 1.0, "is the live view of a signal; write to the signal table"),
    ],
)
def test_a_wrong_value_is_refused(attribute: Attribute, given: object, message: str) -> None:
    with pytest.raises(KnowledgeError, match=message):
        attribute.check(given)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Relation("x", (), (), {"target": Attribute(str)}), "relation 'x' declares target"),
        (lambda: Relation("x", (), (), {"v": Attribute(Live)}), "only nodes can have one"),
        (lambda: Attribute(list), "no attribute can be of the type .*list.*; use one of: float"),
        (lambda: Attribute(float, low=0.0, default=-1.0), "found -1.0"),
    ],
)
def test_a_wrong_schema_is_refused(make: object, message: str) -> None:
    with pytest.raises(KnowledgeError, match=message):
        make()
