"""Missions of py_trees' own nodes, and what goes wrong with them."""

from __future__ import annotations

import py_trees
import pytest
from py_trees.behaviours import Running, Success
from py_trees.common import Status

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import NodeTicked, TicketChanged
from rocs_bt.plan import action_nodes
from rocs_bt.trees.nodes import BUILTIN, Instant, Tree

from ..trees.with_py_trees import Letters, node


class TestMissions:
    def test_a_mission_may_be_of_our_nodes_and_py_trees_mixed(self, mind):
        root = node(
            "ReactiveSequence",
            mind.mission.when("front > 0.5 m"),
            py_trees.composites.Sequence("stock", memory=True, children=[mind.mission.wait(0.1), Running("on")]),
        )
        plan = mind.start(root)
        mind.rig.knowledge.signals.write("front", [0.9], mind.rig.clock.now())
        mind.run(4)
        assert plan.status == "RUNNING"
        mind.rig.knowledge.signals.write("front", [0.2], mind.rig.clock.now())
        mind.run(2)
        assert plan.status == "FAILURE"
        assert plan.reason == "ReactiveSequence/front > 0.5 m: 'front > 0.5 m' does not hold: front = 0.2 m"
        last = {e.node: e.status for e in mind.rig.of(NodeTicked)}
        assert last["ReactiveSequence/stock/on"] == "INVALID"

    def test_a_mission_that_its_conditions_skip_has_failed(self, mind):
        plan = mind.start(node("AlwaysSuccess", _skipIf="true"))
        mind.run(1)
        assert (plan.status, plan.reason) == (
            "FAILURE",
            "AlwaysSuccess: the conditions of the root skip the whole mission",
        )

    def test_a_leaf_without_an_outcome_is_named(self, mind):
        plan = mind.start(node("Sequence", Success("fine"), type("Bad", (Instant,), {"update": lambda self: 7})("bad")))
        with pytest.raises(InputError, match="bad"):
            plan.run(0.0)

    def test_an_action_of_the_table_is_a_node_with_ports_in_units(self, mind):
        mind.rig.knowledge.world.place("dock", Pose2(0.4, 0.0), kind="goal")
        nodes = BUILTIN.with_(action_nodes(mind.rig.actions))
        leaf = nodes.make("GoTo", "there", [], {"goal": "{where}", "cruise": "30 cm/s"})
        begin = node("Script", code="where := 'dock'")
        plan = mind.start(node("Sequence", begin, leaf, name="go"))
        mind.until_done()
        assert plan.status == "SUCCESS"
        assert (leaf.ticket.action.goal, leaf.ticket.action.cruise) == ("dock", pytest.approx(0.3))
        assert {e.by for e in mind.rig.of(TicketChanged)} >= {"go/there"}


class TestErrors:
    def test_the_node_that_cannot_go_on_is_told_by_its_path(self):
        inner = node("Sequence", node("AlwaysSuccess"), node("Script", code="x = 1", name="write"))
        tree = Tree(node("Fallback", node("SubTree", inner, name="sub", ID="T")))
        with pytest.raises(InputError, match=r"^sub/write: the script 'x = 1' fails: the key 'x' does not exist"):
            tree.tick()

    @pytest.mark.parametrize("condition", ["_failureIf", "_successIf", "_skipIf", "_while", "_onSuccess", "_post"])
    def test_so_is_one_whose_condition_cannot_be_asked(self, condition):
        tree = Tree(node("Sequence", node("AlwaysSuccess", name="a", **{condition: "x > 1"})))
        with pytest.raises(InputError, match=r"^a: the script 'x > 1' fails"):
            tree.tick()

    def test_any_other_error_gets_the_path_as_a_note(self):
        rotten = type("Rotten", (Instant,), {"update": lambda self: 1 / 0})("bad")
        with pytest.raises(ZeroDivisionError) as caught:
            Tree(node("Sequence", rotten)).tick()
        assert caught.value.__notes__ == ["in the node 'bad'"]

    def test_after_an_error_everything_that_runs_can_still_be_halted(self):
        work = Letters("work", "R")
        rotten = type("Rotten", (Instant,), {"update": lambda self: 1 / 0})("bad")
        tree = Tree(node("Parallel", work, rotten))
        with pytest.raises(ZeroDivisionError):
            tree.tick()
        tree.halt()
        assert work.status is Status.INVALID
