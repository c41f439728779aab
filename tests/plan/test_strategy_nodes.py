"""SelectStrategy and UseStrategy: the best strategy first, then its fallbacks; and what came of each is kept."""

import pytest

from rocs_bt.actions import ACTIONS
from rocs_bt.catalog import Catalog
from rocs_bt.plan import mission_nodes
from rocs_bt.trees.nodes import FAILURE, RUNNING, SUCCESS, Tree
from rocs_bt.trees.xml import load_xml

NODES = mission_nodes(ACTIONS, Catalog().load_nodes())
LINE = """
<UseStrategy selected="{way}">
  <Switch2 variable="{way}" case_1="through" case_2="around">
    <ScriptCondition code="open == 1"/>
    <Sequence><Sleep msec="100"/><ScriptCondition code="free == 1"/></Sequence>
    <AlwaysFailure name="nobody knows how"/>
  </Switch2>
</UseStrategy>"""


@pytest.fixture
def grow(mind):
    """A tree from one line of XML."""

    def grow(line):
        root = load_xml(f'<root BTCPP_format="4"><BehaviorTree ID="M">{line}</BehaviorTree></root>', NODES)
        return Tree(root, board=mind.mission.board, clock=mind.rig.clock, owner=mind.mission)

    return grow


@pytest.fixture
def strategies(mind):
    model = mind.rig.knowledge.strategy
    model.add("around")
    model.add("through", preference=0.5, falls_back_to="around")
    return model


@pytest.fixture
def tree(grow, strategies):
    tree = grow(LINE)
    tree.board.update({"open": 1, "free": 1})
    return tree


def uses(mind):
    graph = mind.rig.knowledge.graph
    return [
        (graph.related(u, "use_of")[0], graph.get(u, "outcome"), graph.get(u, "reason")) for u in graph.nodes("use")
    ]


def until_done(tree, mind):
    for _ in range(100):
        if (outcome := tree.tick()) is not RUNNING:
            return outcome
        mind.rig.clock.advance()
    raise AssertionError("it does not end")


def test_the_best_is_used_and_its_success_kept(tree, mind):
    assert tree.tick() is SUCCESS
    assert tree.board["way"] == "through"
    assert uses(mind) == [("through", "success", None)]


def test_where_it_fails_its_fallback_is_used(tree, mind, strategies):
    tree.board["open"] = 0
    assert until_done(tree, mind) is SUCCESS
    assert [use[:2] for use in uses(mind)] == [("through", "failure"), ("around", "success")]
    assert strategies.used() == "around"
    assert mind.rig.knowledge.graph.get("use_2", "why").startswith("'through' falls back to it\nsituation: ")


def test_after_enough_failures_it_is_tried_later(tree, mind):
    tree.board["open"] = 0
    for _ in range(4):
        assert until_done(tree, mind) is SUCCESS
    assert uses(mind)[-1][0] == "around"
    assert uses(mind)[-2][0] == "around", "the last round began with it"


def test_when_none_is_left_it_fails_with_all_the_reasons(tree, mind):
    tree.board.update({"open": 0, "free": 0})
    assert until_done(tree, mind) is FAILURE
    assert [use[:2] for use in uses(mind)] == [("through", "failure"), ("around", "failure")]
    told = tree.root.feedback_message
    assert told.startswith("CANNOT: no strategy is applicable.")
    assert "through: no, it has just failed" in told
    tree.board["open"] = 1
    assert until_done(tree, mind) is SUCCESS, "the next time it begins anew"


def test_a_halt_is_kept_as_such_and_counts_neither_way(tree, mind, strategies):
    tree.board["open"] = 0
    assert tree.tick() is RUNNING
    tree.root.halt()
    assert uses(mind)[-1][:2] == ("around", "halted")
    assert [use.strategy for use in strategies.uses()] == ["through"]
    assert tree.tick() is RUNNING


class TestSelectStrategy:
    def test_by_name_and_then_along_the_fallbacks(self, mind, grow):
        strategies = mind.rig.knowledge.strategy
        strategies.add("wait")
        strategies.add("around", falls_back_to="wait")
        tree = grow('<SelectStrategy strategy="around" selected="{way}"/>')
        assert tree.tick() is SUCCESS
        assert (strategies.used(), tree.board["way"]) == ("around", "around")
        tree = grow('<SelectStrategy selected="{way}"/>')
        assert tree.tick() is SUCCESS
        assert (strategies.used(), tree.board["way"]) == ("wait", "wait")
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "CANNOT: 'wait' has no fallback"

    def test_where_none_is_in_force_it_takes_the_best(self, mind, grow):
        strategies = mind.rig.knowledge.strategy
        strategies.add("wait")
        strategies.add("rush", preference=1.0, guard="goal")
        assert grow("<SelectStrategy/>").tick() is SUCCESS
        assert strategies.used() == "wait"
