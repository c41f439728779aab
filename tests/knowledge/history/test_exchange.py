"""Exports read back as what they were; what somebody else wrote is checked, and every fault is told at its place."""

from __future__ import annotations

import json
import math
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import NullSink
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import (
    History,
    State,
    from_json_text,
    to_json_text,
    write_state,
)

from .worlds import STEPS, WIDE, Step, World, held

FILE = Path("given.json")


def home() -> KnowledgeGraph:
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2", WIDE)
    graph.add("R2", "robot")
    graph.add("home", "place", pose=Pose2(1.0, 2.0, 0.5))
    graph.add("door", "door", open=True)
    graph.add("box", "object", radius=math.inf)
    graph.relate("box", "near", "home", distance=0.5)
    graph.relate("R2", "near", "box")
    return graph


@settings(max_examples=50, deadline=None)
@given(steps=STEPS)
def test_json_is_read_back_to_the_last_byte_and_through_a_journal_too(steps: list[Step]) -> None:
    world = World()
    for step in steps:
        world.take(step)
    text = to_json_text(State.of(world.graph))
    state = from_json_text(text, FILE, WIDE)
    assert to_json_text(state) == text
    assert held(state) == held(world.graph)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "k.sqlite"
        write_state(path, state, "import")
        with History(path, schema=WIDE) as history:
            assert to_json_text(history.as_of()) == text


def broken(**changes: Any) -> str:
    """The export of `home` with some of it replaced."""
    document = json.loads(to_json_text(State.of(home())))
    document.update(changes)
    return "{\n" + ",\n".join(f"{json.dumps(k)}: {_lines(v)}" for k, v in document.items()) + "\n}"


def _lines(value: Any) -> str:
    if not isinstance(value, list):
        return json.dumps(value)
    return "[\n" + ",\n".join(map(json.dumps, value)) + "\n]"


def node(name: Any, kind: str = "place", **changes: Any) -> dict[str, Any]:
    return {"name": name, "kind": kind, "t": 0.0, "revision": 1, "attributes": {"pose": [0.0, 0.0, 0.0]}, **changes}


def edge(source: str, relation: str, target: str, **changes: Any) -> dict[str, Any]:
    return {"source": source, "relation": relation, "target": target, "t": 0.0, "revision": 1, **changes}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", r"given\.json:1:1: this is not valid JSON"),
        ("{", r"given\.json:1:2: this is not valid JSON"),
        ('{"a": 1 "b": 2}', r":1:9: .*Expecting ','"),
        ('{"a": 1, "a": 2}', r"'a' is repeated"),
        ('{"a": {"b": 1, "b": 2}}', r"'b' is repeated"),
        ('{"a": NaN}', r"NaN is not allowed"),
        ('{"a": ' + "1" * 5000 + "}", r"this is not valid JSON"),
        ('{"a": ' + "[" * 100_000 + "}", r"this is not valid JSON"),
        ("{}", r"there is no 'format'(.|\n)*there is no 'edges'"),
        (broken(format="knowledge/9"), r"'knowledge/9'; this version of rocs_bt reads 'knowledge/1'"),
        (broken(agent=3, revision=-1, t="noon"), r"agent must be a text(.|\n)*revision must be(.|\n)*time must be"),
        (broken(more=1), "unknown key 'more'"),
        (broken(nodes=[node("a"), node("a")]), r":8:1: node 'a' exists already"),
        (broken(nodes=[node("a", "palce")]), r"no kind named 'palce'.*place"),
        (broken(nodes=[node("")], edges=[]), r":7:1: this is not a node: .*length"),
        (broken(nodes=[node("a", attributes={})], edges=[]), "needs pose"),
        (broken(nodes=[node("a", attributes={"pose": [0.0]})]), "must be a Pose2"),
        (broken(nodes=[node("a", attributes={"pose": [0.0, 0.0, {"float": "nan"}]})]), "must be"),
        (broken(nodes=[node("a", attributes={"pose": {"x": 1}})]), "an object must be"),
        (broken(nodes=[node("a", kind="sensor", attributes={"values": [1.0]})]), "live view"),
        (broken(nodes=[node("a", stamps={"size": [0.0, 1]})]), "a stamp of 'size'"),
        (broken(nodes=[node("a", stamps={"pose": [0.0, 2**70]})]), "not a node"),
        (broken(nodes=[node("a", colour="red")]), "unknown field `colour`"),
        (broken(edges=[edge("box", "near", "hoem")]), r"no node named 'hoem'.*home"),
        (broken(edges=[edge("box", "naer", "home")]), r"no relation named 'naer'.*near"),
        (broken(edges=[edge("box", "near", "home"), edge("box", "near", "home")]), "is there twice"),
        (broken(edges=[edge("box", "near", "home", attributes={"kind": 1.0})]), "no attribute 'kind'"),
        (broken(edges=[edge("home", "connects", "box")]), "cannot end at 'box'"),
        (
            broken(
                nodes=[node("R2", "robot", attributes={}), node("a", "goal"), node("b", "goal")],
                edges=[edge("R2", "pursues", "a"), edge("R2", "pursues", "b")],
            ),
            "'R2' pursues 'a' already, and may have one only",
        ),
    ],
)
def test_what_is_wrong_with_an_import_is_told_at_its_place(text: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        from_json_text(text, FILE, WIDE)


def test_all_faults_are_told_at_once() -> None:
    text = broken(nodes=[node("a", "x"), node("b", "y"), node("c")], edges=[edge("c", "z", "c")])
    with pytest.raises(InputError) as caught:
        from_json_text(text, FILE, WIDE)
    assert [(f.line, f.column) for f in caught.value.faults] == [(7, 1), (8, 1), (12, 1)]


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=8,
)
FIELDS = st.sampled_from(["name", "kind", "t", "revision", "attributes", "stamps", "source", "relation", "target"])
ENTRY = st.dictionaries(FIELDS, JSON | st.sampled_from(["place", "home", "near", "a"]), max_size=6)


@settings(max_examples=100, deadline=None)
@given(
    nodes=st.lists(ENTRY | JSON, max_size=3),
    edges=st.lists(ENTRY | JSON, max_size=3),
    head=st.dictionaries(st.sampled_from(["agent", "t", "revision", "format"]), JSON, max_size=2),
)
def test_no_document_raises_anything_but_its_faults(nodes: list[Any], edges: list[Any], head: dict[str, Any]) -> None:
    document = {"format": "knowledge/1", "agent": "R2", "t": 0, "revision": 0, "nodes": nodes, "edges": edges, **head}
    try:
        state = from_json_text(json.dumps(document), FILE, WIDE)
    except InputError as error:
        assert error.faults
        return
    assert to_json_text(from_json_text(to_json_text(state), FILE, WIDE)) == to_json_text(state)
