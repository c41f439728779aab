"""The nodes, one truth after the other; the traps of BehaviorTree.CPP's semantics by name.

Where 4.8.2 does the same, test_conformance.py compares random trees with the C++ engine; what only later versions have,
and what we do otherwise on purpose (docs/bring-a-mission.md), stands here.
"""

from __future__ import annotations

import pytest
from py_trees.behaviours import Dummy, Failure, Success
from py_trees.common import Status
from py_trees.composites import Sequence as StockSequence

from rocs_bt.base.errors import InputError
from rocs_bt.declare import summary_of
from rocs_bt.trees.nodes import BUILTIN, CONDITIONS, Instant, Leaf, Tree
from rocs_bt.trees.status import IDLE, SUCCESS


@pytest.mark.parametrize(
    ("tag", "letters", "stories"),
    [
        ("IfThenElse", ["F", "S"], ["FAILURE A.start=F", "FAILURE A.start=F"]),  # 4.8.2 asks only once in its life
        ("TryCatch", ["S", "F", "RS"], ["RUNNING A.start=S B.start=F C.start=R", "FAILURE C.run=S"]),
        ("TryCatch", ["S", "S", "S"], ["SUCCESS A.start=S B.start=S"]),
        ("TryCatch", ["K", "S"], ["SKIPPED A.start=K"]),
    ],
)
def test_what_a_control_does(bench, tag, letters, stories):
    assert bench.of(tag, *letters).ticks(len(stories)) == stories


class TestTraps:
    def test_a_stateful_condition_that_nobody_resets_is_not_asked_again(self, bench):
        bench.of("WhileDoElse", "SF", "RRS", "S")
        assert bench.ticks(3) == ["RUNNING A.start=S B.start=R", "RUNNING B.run=R", "SUCCESS B.run=S"]

    def test_and_goes_through_when_the_tree_is_settled(self, bench):
        tree = bench.of("Repeat", "S", num_cycles=3).built
        assert tree.settle() is SUCCESS
        assert len(bench.log) == 3

    def test_skipped_is_told_and_never_stored(self, bench):
        root = bench.leaf("A", "S", _skipIf="true")
        assert bench.tree(root).tick() == "SKIPPED"
        assert root.status is IDLE

    def test_post_runs_on_no_halt(self, bench):
        bench.tree(bench.leaf("A", "R", _post="n += 1", _onHalted="h += 1"), n=0, h=0)
        bench.tick()
        bench.built.halt()
        assert bench.built.board.texts() == {"h": "1", "n": "0"}

    def test_precondition_is_not_asked_while_the_child_is_under_way(self, bench):
        bench.of("Precondition", "RRS", if_="x == 1", else_="RUNNING")
        bench.built.board["x"] = 0
        assert bench.tick() == "RUNNING"
        bench.built.board["x"] = 1
        assert bench.tick() == "RUNNING A.start=R"
        bench.built.board["x"] = 0
        assert bench.ticks(2) == ["RUNNING A.run=R", "SUCCESS A.run=S"]

    def test_parallel_refuses_a_count_that_it_can_never_reach(self, bench):
        with pytest.raises(InputError, match="waits for 3 children but has 2"):
            bench.of("Parallel", "S", "S", success_count=3).tick()

    @pytest.mark.parametrize("tag", ["IfThenElse", "WhileDoElse"])
    def test_a_condition_may_not_be_skipped(self, bench, tag):
        with pytest.raises(InputError, match="was skipped"):
            bench.of(tag, "K", "S", "S").tick()


class TestConditions:
    def test_they_are_asked_in_this_order(self, bench):
        every = dict.fromkeys(CONDITIONS[:4], "true")
        assert bench.tree(bench.leaf("A", "S", **every)).tick() == "FAILURE"
        del every["_failureIf"]
        assert bench.tree(bench.leaf("A", "S", **every)).tick() == "SUCCESS"

    def test_only_while_is_asked_of_a_node_that_runs(self, bench):
        bench.tree(bench.leaf("A", "R", _failureIf="x > 0", _while="x < 2"), x=0)
        assert bench.tick() == "RUNNING A.start=R"
        bench.built.board["x"] = 1
        assert bench.tick() == "RUNNING A.run=R"
        bench.built.board["x"] = 2
        assert bench.tick() == "SKIPPED A.halt"

    def test_after_it_has_ended(self, bench):
        told = {"_onSuccess": "t += 's'", "_onFailure": "t += 'f'", "_post": "t += 'p'"}
        for letter in "SFRK":
            bench.tree(bench.leaf("A", letter, **told), t="")
            bench.tick()
            assert bench.built.board["t"] == {"S": "sp", "F": "fp"}.get(letter, "")

    def test_also_when_a_pre_condition_decided(self, bench):
        bench.tree(bench.leaf("A", "R", _failureIf="true", _onFailure="n += 1", _post="n += 1"), n=0)
        assert bench.tick() == "FAILURE"
        assert bench.built.board["n"] == 2


class TestHalts:
    def test_each_running_node_is_halted_once_children_first(self, bench):
        told = {"_onHalted": "t += '{}'"}

        def mark(name):
            return {key: value.format(name) for key, value in told.items()}

        inner = bench.node("Inverter", bench.leaf("A", "R", **mark("a")), **mark("i"))
        root = bench.node("Parallel", inner, bench.leaf("B", "R", **mark("b")), bench.leaf("C", "S"), **mark("p"))
        bench.tree(root, t="")
        bench.tick()
        bench.built.halt()
        bench.built.halt()
        assert bench.built.board["t"] == "aibp"
        assert bench.log == ["A.start=R", "B.start=R", "C.start=S", "A.halt", "B.halt"]

    @pytest.mark.parametrize("tag", ["SkipUnlessUpdated", "WaitValueUpdate"])
    def test_what_waits_for_a_key_halts_its_child_too(self, bench, tag):
        """Theirs leaves it running."""
        bench.tree(bench.node(tag, "R", entry="{x}"), x=1)
        bench.tick()
        bench.built.halt()
        assert bench.log[-1] == "A.halt"

    def test_try_catch_may_clean_up_when_it_is_halted(self, bench):
        bench.of("TryCatch", "R", "S", catch_on_halt=True)
        bench.tick()
        bench.built.halt()
        assert bench.log == ["A.start=R", "A.halt", "B.start=S"]


@pytest.mark.parametrize("wrong", [None, Status.INVALID, True])
@pytest.mark.parametrize("base", [Leaf, Instant])
def test_a_leaf_that_gives_no_outcome_is_named(base, wrong):
    rotten = type("Rotten", (base,), {"update": lambda self: wrong})
    with pytest.raises(InputError, match=r"'b' \(Rotten\) returned .* instead of a status"):
        Tree(BUILTIN.make("Sequence", "s", [rotten("b")], {})).tick()


@pytest.mark.parametrize("tag", sorted(BUILTIN))
def test_every_node_says_what_it_and_its_ports_are_for(tag):
    node = BUILTIN[tag]
    assert summary_of(node).endswith((".", "_count`."))
    assert all(port.doc for port in node.ports.values())


def test_py_trees_own_nodes_may_stand_anywhere(bench):
    stock = StockSequence("stock", memory=True, children=[Success("a"), bench.leaf("L", "RS"), Dummy("d")])
    bench.of("Fallback", Failure("f"), stock)
    assert bench.ticks(2) == ["RUNNING L.start=R", "RUNNING L.run=S"]
    bench.built.halt()
    assert stock.status is IDLE
