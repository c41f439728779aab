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
from rocs_bt.trees.nodes import BUILTIN, Instant, Leaf, Tree
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


class TestHalts:
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
    assert node.description().endswith((".", "_count`."))
    assert all(port.doc for port in node.ports.values())


def test_py_trees_own_nodes_may_stand_anywhere(bench):
    stock = StockSequence("stock", memory=True, children=[Success("a"), bench.leaf("L", "RS"), Dummy("d")])
    bench.of("Fallback", Failure("f"), stock)
    assert bench.ticks(2) == ["RUNNING L.start=R", "RUNNING L.run=S"]
    bench.built.halt()
    assert stock.status is IDLE
