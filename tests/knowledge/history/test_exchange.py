"""Exports read back as what they were; what somebody else wrote is checked (the table of messages has the faults)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.knowledge.history import GraphState, from_json_text, to_json_text

from .worlds import STEPS, WIDE, Step, World, held

FILE = Path("given.json")


@settings(max_examples=50, deadline=None)
@given(steps=STEPS)
def test_json_is_read_back_to_the_last_byte(steps: list[Step]) -> None:
    world = World()
    for step in steps:
        world.take(step)
    text = to_json_text(GraphState.of(world.graph), GraphState("R3", WIDE))
    states = from_json_text(text, FILE, WIDE)
    assert to_json_text(*states.values()) == text
    assert held(states["R2"]) == held(world.graph)
    for node in world.graph.nodes():
        assert states["R2"].written(node) == GraphState.of(world.graph).written(node)
    assert not states["R3"].nodes()


def test_a_number_with_too_many_digits_is_told() -> None:
    with pytest.raises(InputError, match="this is not valid JSON"):
        from_json_text('{"a": ' + "1" * 5000 + "}", FILE, WIDE)


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
