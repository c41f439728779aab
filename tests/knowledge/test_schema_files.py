"""Schema files: what they declare, what they may not, and where it is told."""

from __future__ import annotations

import math
import random
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError, KnowledgeError
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.units import LENGTH, NONE, SPEED, TIME, TURN_RATE
from rocs_bt.event import NullSink
from rocs_bt.knowledge import (
    POSE,
    SCHEMA,
    Attribute,
    KnowledgeGraph,
    NodeKind,
    Relation,
    Schema,
    load_schema,
    schema_text,
)

CHARGER = """
format = "schema/1"
[kind.charger]
doc = "Where a robot fills its battery"
extends = "place"
[kind.charger.attributes]
power = { type = "number", unit = "W", low = "0 W", high = "2000 W", default = "50 W", doc = "that it gives" }
plug = { type = "text", choices = ["A", "B"] }
[kind.robot.attributes]
battery = { type = "number", low = 0, high = 1 }
[relation.docks_at]
sources = ["robot"]
targets = ["charger"]
max_sources = 1
"""


def load(tmp_path: Path, text: str, base: Schema | None = SCHEMA) -> Schema:
    file = tmp_path / "own.toml"
    file.write_text(text, encoding="utf-8")
    return load_schema([file], base)


def graph_of(schema: Schema) -> KnowledgeGraph:
    return KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2", schema)


def test_a_project_adds_kinds_attributes_and_relations(tmp_path: Path) -> None:
    graph = graph_of(load(tmp_path, CHARGER))
    graph.add("R2", "robot", battery=0.5)
    graph.add("R3", "robot")
    graph.add("dock", "charger", pose=Pose2(1.0, 2.0), plug="A")
    assert graph.attributes("dock") == {"pose": Pose2(1.0, 2.0), "tolerance": 0.1, "power": 50.0, "plug": "A"}
    assert graph.nodes("place") == graph.nodes("thing")[-1:] == ["dock"]
    graph.relate("R2", "at", "dock")  # as at any place
    graph.relate("R2", "docks_at", "dock")
    with pytest.raises(KnowledgeError, match="'docks_at' allows 'dock' at most 1 sources, and it has R2; unrelate one"):
        graph.relate("R3", "docks_at", "dock")
    with pytest.raises(KnowledgeError, match="'plug' of 'charger dock' must be one of A, B, found 'C'"):
        graph.set("dock", plug="C")
    with pytest.raises(KnowledgeError, match=r"'power' of 'charger dock' must be a number .* in \[0, 2000\]"):
        graph.set("dock", power=3000.0)
    assert "charger" not in SCHEMA.kinds


def test_files_may_name_each_others_kinds(tmp_path: Path) -> None:
    for name, text in {"a": '[kind.tail]\nextends = "leg"\n', "b": "[kind.leg]\n"}.items():
        (tmp_path / f"{name}.toml").write_text(f'format = "schema/1"\n{text}', encoding="utf-8")
    schema = load_schema([tmp_path / "a.toml", tmp_path / "b.toml"])
    assert schema.lineages["tail"] == ("tail", "leg")
    assert schema.families["leg"] == {"leg", "tail"}


def test_cardinality_holds_in_both_directions() -> None:
    schema = Schema.of(
        [NodeKind("a"), NodeKind("b")],
        [Relation("two", ("a",), ("b",), max_targets=2), Relation("one", ("a",), ("b",), single=True, max_sources=1)],
    )
    graph = graph_of(schema)
    for name in ("a1", "a2", "b1", "b2", "b3"):
        graph.add(name, name[0])
    for target in ("b1", "b2", "b1"):  # the last one is there already
        graph.relate("a1", "two", target)
    with pytest.raises(KnowledgeError, match="'two' allows 'a1' at most 2 targets, and it has b1, b2"):
        graph.relate("a1", "two", "b3")
    graph.relate("a1", "one", "b1")
    with pytest.raises(KnowledgeError, match="'one' allows 'b1' at most 1 sources, and it has a1"):
        graph.relate("a2", "one", "b1")
    graph.relate("a1", "one", "b2")  # lets go of b1
    graph.relate("a2", "one", "b1")
    assert graph.related("a1", "one") == ["b2"]
    assert graph.relating("b1", "one") == ["a2"]


def test_a_kind_may_narrow_what_it_inherits() -> None:
    wide = NodeKind("wide", {"v": Attribute(float, low=0.0), "w": Attribute(str)})
    narrow = NodeKind("narrow", {"v": Attribute(float, required=True, low=1.0, high=2.0)}, extends="wide")
    graph = graph_of(Schema.of([narrow, wide], []))
    with pytest.raises(KnowledgeError, match="narrow 'x' needs v"):
        graph.add("x", "narrow")
    graph.add("x", "narrow", v=1.5, w="text")
    assert graph.nodes("wide") == ["x"]


def test_all_faults_of_all_files_are_told_at_once(tmp_path: Path) -> None:
    for name, text in {"a": '[kind.x]\nextends = "nothing"', "b": "[kind.A]\n[kind.y]\nzzz = 1"}.items():
        (tmp_path / f"{name}.toml").write_text(f'format = "schema/1"\n{text}', encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_schema([tmp_path / "a.toml", tmp_path / "missing.toml", tmp_path / "b.toml"], SCHEMA)
    told = sorted((fault.file.name, fault.line) for fault in caught.value.faults if fault.file is not None)
    assert told == [("a.toml", 3), ("b.toml", 2), ("b.toml", 4), ("missing.toml", 0)]


UNITS = [NONE, LENGTH, SPEED, TIME, TURN_RATE, LENGTH * LENGTH, NONE / TIME]


def random_schema(rng: random.Random) -> Schema:
    kinds = [
        NodeKind(
            f"k{i}",
            {f"a{i}_{j}": random_attribute(rng) for j in range(rng.randrange(4))},
            rng.choice(["", 'says "so"', "ü\n\x7f\\"]),
            rng.choice([None, f"k{rng.randrange(i)}"]) if i else None,
        )
        for i in range(rng.randrange(1, 6))
    ]
    names = [kind.name for kind in kinds]
    relations = [
        Relation(
            f"r{i}",
            tuple(rng.sample(names, rng.randint(1, len(names)))),
            tuple(rng.sample(names, rng.randint(1, len(names)))),
            {f"b{j}": random_attribute(rng) for j in range(rng.randrange(3))},
            single=(single := rng.random() < 0.3),
            max_targets=None if single else rng.choice([None, 1, 2]),
            max_sources=rng.choice([None, 1, 2]),
        )
        for i in range(rng.randrange(4))
    ]
    return Schema.of(kinds, relations)


def random_attribute(rng: random.Random) -> Attribute:
    unit = rng.choice(UNITS)
    low = rng.choice([-math.inf, 0.0, -1.5])
    match rng.randrange(6):
        case 0:
            return Attribute(float, (unit,), low=low, high=rng.choice([math.inf, 2.0]), default=rng.choice([None, 0.5]))
        case 1:
            return Attribute(int, low=low, default=rng.choice([None, 3]))
        case 2:
            return Attribute(bool, default=rng.choice([None, True, False]), doc="yes or no")
        case 3:
            choices = rng.choice([(), ("a", "b'")])
            return Attribute(str, choices=choices, default=rng.choice([None, *choices]))
        case 4:
            return Attribute(tuple, (unit,), low=low, size=rng.choice([0, 2]), default=rng.choice([None, (0.25, 1.0)]))
    return Attribute(Pose2, POSE, required=rng.random() < 0.2, default=rng.choice([None, Pose2(1.0, -2.0, 0.5)]))


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10**9))
def test_what_is_written_is_read_again(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    schema = random_schema(random.Random(seed))
    folder = tmp_path_factory.mktemp("schema")
    again = load(folder, schema_text(schema), None)
    assert again == schema
    assert again.declared == schema.declared
    assert schema_text(again) == schema_text(schema)


def test_the_shipped_schema_is_written_and_read_again(tmp_path: Path) -> None:
    assert load(tmp_path, schema_text(SCHEMA), None) == SCHEMA
