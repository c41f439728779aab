"""Recorded blackboard values: each change once, short, with the path of its subtree; none without a change."""

from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.event import BlackboardChanged
from rocs_bt.plan.board_changes import MAX_TEXT, BoardChanges, short_text
from rocs_bt.trees.nodes import BUILTIN, Tree
from rocs_bt.trees.xml import load_xml

XML = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main"><Repeat num_cycles="3"><Sequence>
    <Script code="n := 2; same := 'a'"/><SubTree ID="Sub" name="s" x="{n}"/><UnsetBlackboard key="n"/>
  </Sequence></Repeat></BehaviorTree>
  <BehaviorTree ID="Sub"><Script code="x += 1; own := 'b'"/></BehaviorTree>
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
