"""Exports read back as what they were; what somebody else wrote is checked, and every fault is told at its place."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import NullSink
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import State, from_json_text, to_json_text

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
def test_json_is_read_back_to_the_last_byte(steps: list[Step]) -> None:
    world = World()
    for step in steps:
        world.take(step)
    text = to_json_text(State.of(world.graph), State("R3", WIDE))
    states = from_json_text(text, FILE, WIDE)
    assert to_json_text(*states.values()) == text
    assert held(states["R2"]) == held(world.graph)
    for node in world.graph.nodes():
        assert states["R2"].written(node) == State.of(world.graph).written(node)
    assert not states["R3"].nodes()


def broken(**changes: Any) -> str:
    """The export of `home` with some of it replaced; its agent begins on line 4, its nodes on line 8."""
    (agent,) = json.loads(to_json_text(State.of(home())))["agents"]
    agent |= changes
    lines = ",\n".join(f"{json.dumps(k)}: {_lines(v)}" for k, v in agent.items())
    return f'{{\n"format": "knowledge/1",\n"agents": [\n{{{lines}}}]\n}}'


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
        ("[]", "it must be an object"),
        ('{"agents": 3}', "'agents' must be a list"),
        ("{}", r"there is no 'format'(.|\n)*there is no 'agents'"),
        ('{"format": "knowledge/9", "agents": []}', r"'knowledge/9'; this version of rocs_bt reads 'knowledge/1'"),
        ('{"format": "knowledge/1", "agents": [], "more": 1}', "unknown key 'more'"),
        ('{"format": "knowledge/1", "agents": [3]}', r":1:1: this is not the knowledge of an agent: .*object"),
        (broken(agent=3), r":4:1: this is not the knowledge of an agent: Expected `str`, got `int` - at `\$\.agent`"),
        (broken(revision=-1), r":4:1: .*revision"),
        (broken(t="noon"), r":4:1: .*\$\.t"),
        (broken(more=1), r":4:1: .*unknown field `more`"),
        (broken(nodes=[node("a"), node("a")]), r":9:1: node 'a' exists already"),
        (broken(nodes=[node("a", "palce")]), r"no kind named 'palce'.*place"),
        (broken(nodes=[node("")], edges=[]), r":8:1: this is not a node: .*length"),
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
    assert [(f.line, f.column) for f in caught.value.faults] == [(8, 1), (9, 1), (13, 1)]


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
    head=st.dictionaries(st.sampled_from(["agent", "t", "revision"]), JSON, max_size=2),
)
def test_no_document_raises_anything_but_its_faults(nodes: list[Any], edges: list[Any], head: dict[str, Any]) -> None:
    agent = {"agent": "R2", "t": 0, "revision": 0, "nodes": nodes, "edges": edges, **head}
    try:
        states = from_json_text(json.dumps({"format": "knowledge/1", "agents": [agent]}), FILE, WIDE)
    except InputError as error:
        assert error.faults
        return
    text = to_json_text(*states.values())
    assert to_json_text(*from_json_text(text, FILE, WIDE).values()) == text


def test_two_states_of_one_agent_are_a_fault() -> None:
    text = to_json_text(State("R2"), State("R2"))
    with pytest.raises(InputError, match=r":11:1: agent 'R2' is there twice"):
        from_json_text(text, FILE)
