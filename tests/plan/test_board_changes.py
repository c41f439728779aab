"""Recorded blackboard values: each change once, short, with the path of its subtree; none without a change.

A port's value at a time is found from the recording alone: the node's `keys` name a track of the topic `board`.
"""

from collections import deque

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.event import BlackboardChanged, SubtreeSwapped
from rocs_bt.plan.board_changes import MAX_TEXT, BoardChanges, short_text
from rocs_bt.record.file.header import AgentInfo, RunHeader
from rocs_bt.record.fold.tracks import Tracks
from rocs_bt.trees.nodes import BUILTIN, Tree
from rocs_bt.trees.xml import load_xml

XML = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main"><Repeat num_cycles="3"><Sequence>
    <Script code="n := 2; same := 'a'"/><SubTree ID="Sub" name="s" x="{n}"/><UnsetBlackboard key="n"/>
  </Sequence></Repeat></BehaviorTree>
  <BehaviorTree ID="Sub"><Script code="x += 1; own := 'b'"/></BehaviorTree>
</root>"""

REMAPPED = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main"><Repeat num_cycles="3"><Sequence>
    <Sleep msec="150"/><Script code="n := 2; far := '1;2'"/><SubTree ID="Sub" name="s" x="{n}" lit="7"/>
    <SubTree ID="Sub" name="s" x="{=}" lit="8"/><SubTree ID="Auto" _autoremap="true"/>
    <SetBlackboard value="{n}" output_key="copy"/>
  </Sequence></Repeat></BehaviorTree>
  <BehaviorTree ID="Sub"><Sequence>
    <Script code="x := 1; own := 'b'"/><SetBlackboard value="{lit}" output_key="{=}"/><SubTree ID="Inner" y="{x}"/>
  </Sequence></BehaviorTree>
  <BehaviorTree ID="Inner"><SetBlackboard value="{y}" output_key="@top"/></BehaviorTree>
  <BehaviorTree ID="Auto"><SetBlackboard value="{far}" output_key="_mine"/></BehaviorTree>
</root>"""


def test_changes_of_a_mission_are_events(mind):
    plan = mind.start(load_xml(XML))
    for _ in range(4):
        plan.run(mind.rig.clock.now())
        mind.rig.run()
    found = [(e.subtree, e.key, e.value) for e in mind.rig.sink.events if isinstance(e, BlackboardChanged)]
    assert found == [("", "same", "a"), ("s", "own", "b")]  # n was removed again in the same tick


@given(st.lists(st.sampled_from([None, 1, 1.5, "a", "b", True, [1] * 99, {"a": 1}, "x" * 500]), max_size=12))
def test_a_key_is_reported_when_its_text_differs_from_the_last_one(values):
    tree = Tree(BUILTIN["AlwaysSuccess"]("leaf"))
    changes, last = BoardChanges(tree), ""
    for value in values:
        if value is None:
            tree.board.unset("k")
        else:
            tree.board.set_local("k", value)
        now = "" if value is None else short_text(value)
        assert len(now) <= MAX_TEXT
        assert [*changes.take()] == ([("", "k", now)] if now != last else [])
        last = now


def test_a_value_that_is_changed_in_place_is_reported():
    tree = Tree(BUILTIN["AlwaysSuccess"]("leaf"))
    changes = BoardChanges(tree)
    for value in ([1, 2], deque([1, 2]), {1: 2}, {1, 2}):
        tree.board.set_local("k", value)
        assert [*changes.take()] == [("", "k", short_text(value))]
        value.pop() if not isinstance(value, dict) else value.clear()
        assert [*changes.take()] == [("", "k", short_text(value))]
        assert not [*changes.take()]


@pytest.mark.filterwarnings("ignore:warning. two SubTrees")
def test_the_value_of_each_port_is_found_in_the_recording(mind):
    plan = mind.start(load_xml(REMAPPED))
    header = RunHeader(scenario="x", seed=1, agents=(AgentInfo(name="", robot="r", mission="m"),))
    tracks, described, taken, found = Tracks(header), {}, 0, set()
    for _ in range(8):
        plan.run(mind.rig.clock.now())
        if not described:
            plan.swap(next(o.path for o in plan.outline if o.kind == "SubTree"), load_xml(XML))
        events = mind.rig.sink.events
        tracks.take(events[taken:])
        for swap in (e for e in events[taken:] if isinstance(e, SubtreeSwapped)):
            described = {node.path: node for node in swap.nodes}
        taken, described = len(events), described or {node.path: node for node in plan.tree_nodes()}
        for path, node in described.items():
            live = plan.find(path)
            for port, track in node.keys.items():
                key = live.remaps[port] if node.type == "SubTree" else str(live.given[port])
                key = key.strip("{}") if key.strip("{}") != "=" else port
                entry = live.board.entry(key)
                shown = tracks.state(tracks.end, mind.rig.sink.events[0].agent, "board").get(track)
                value = None if entry is None else entry.value
                assert shown == (None if value is None else short_text(value)), (path, port)
                found.add((node.type, port, shown))
        mind.rig.run()
    assert {("SetBlackboard", "value", "8"), ("SetBlackboard", "value", "1;2"), ("SubTree", "x", "1")} <= found


def test_numbers_of_a_route_are_short():
    assert short_text([(1.0270961555239795, 3.0)]) == "[(1.0271, 3)]"
