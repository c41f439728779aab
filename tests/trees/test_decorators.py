"""Decorators, switches and nodes for navigation, where test_conformance.py has no C++ engine to compare with."""

from __future__ import annotations

import pytest

from rocs_bt.trees.nodes import Tree

from .scripted import Bench


@pytest.mark.parametrize(
    ("tag", "attributes", "letters", "stories"),
    [
        ("Delay", {"delay_msec": "150"}, "RS", ["RUNNING", "RUNNING", "RUNNING A.start=R", "SUCCESS A.run=S"]),
        ("Timeout", {"msec": "150"}, "R", ["RUNNING A.start=R", "RUNNING A.run=R", "FAILURE A.halt"]),
        ("Timeout", {"msec": "0"}, "RRRS", ["RUNNING A.start=R"] + ["RUNNING A.run=R"] * 2 + ["SUCCESS A.run=S"]),
        ("Timeout", {"msec": "150"}, "RS", ["RUNNING A.start=R", "SUCCESS A.run=S", "SUCCESS A.start=S"]),
        ("LoopString", {"queue": "", "if_empty": "SKIPPED"}, "S", ["SKIPPED"]),
        ("LoopBool", {"queue": "true;0"}, "F", ["FAILURE A.start=F"]),
    ],
)
def test_what_a_decorator_does(bench, tag, attributes, letters, stories):
    assert bench.of(tag, letters, **attributes).ticks(len(stories)) == stories


def test_a_loop_empties_the_list_on_the_board(bench):
    bench.tree(bench.node("LoopDouble", "S", queue="{q}", value="{v}"))
    items = bench.built.board["q"] = [1.5, 2.5]
    assert bench.tick() == "RUNNING A.start=S"
    assert (items, bench.built.board["v"]) == ([2.5], 1.5)


def test_a_limit_that_is_a_key_is_read_again_after_each_round(bench):
    child = bench.leaf("A", "F", _onFailure="n = 2")
    bench.tree(bench.node("RetryUntilSuccessful", child, num_attempts="{n}"), n=9)
    assert bench.ticks(2) == ["RUNNING A.start=F", "FAILURE A.start=F"]


@pytest.mark.parametrize(
    ("value", "child"),
    [("1", "A"), (1, "A"), (1.0, "A"), ("two", "B"), (3, "B"), ("other", "C"), (None, "C"), ("01", "A")],
)
def test_a_switch_compares_text_then_numbers_with_enums(bench, value, child):
    root = bench.node("Switch2", "S", "S", "S", variable="{x}", case_1="1", case_2="two")
    bench.built = Tree(root, enums={"two": 3})
    if value is not None:
        bench.built.board["x"] = value
    assert bench.tick() == f"SUCCESS {child}.start=S"


def test_a_switch_that_changes_halts_the_child_it_leaves(bench):
    bench.tree(bench.node("Switch2", "R", "S", "S", variable="{x}", case_1="1", case_2="2"), x=1)
    assert bench.tick() == "RUNNING A.start=R"
    bench.built.board["x"] = 2
    assert bench.tick() == "SUCCESS A.halt B.start=S"


class TestNavigation:
    """Nav2's control nodes; the truths are those of nav2_behavior_tree/test/plugins/control."""

    def test_pipeline(self, bench):
        bench.of("PipelineSequence", "S", "RSR", "RS")
        assert bench.ticks(3) == [
            "RUNNING A.start=S B.start=R",
            "RUNNING A.start=S B.run=S C.start=R",
            "SUCCESS A.start=S B.start=R C.run=S B.halt",
        ]

    def test_recovery(self, bench):
        bench.of("RecoveryNode", "FFS", "S", number_of_retries=2)
        assert bench.tick() == "SUCCESS A.start=F B.start=S A.start=F B.start=S A.start=S"
        assert Bench().of("RecoveryNode", "F", "S").tick() == "FAILURE A.start=F B.start=S A.start=F"
        assert Bench().of("RecoveryNode", "F", "F").tick() == "FAILURE A.start=F B.start=F"
        assert Bench().of("RecoveryNode", "K", "F").tick() == "SKIPPED A.start=K"

    def test_round_robin(self, bench):
        bench.of("RoundRobin", "FS", "S", "F", wrap_around=True)
        assert bench.ticks(2) == ["SUCCESS A.start=F B.start=S", "SUCCESS C.start=F A.start=S"]
        assert Bench().of("RoundRobin", "F", "F").tick() == "FAILURE A.start=F B.start=F"

    def test_nonblocking(self, bench):
        bench.of("NonblockingSequence", "RS", "S")
        assert bench.ticks(2) == ["RUNNING A.start=R B.start=S", "SUCCESS A.run=S B.start=S"]

    def test_persistent(self, bench):
        bench.tree(bench.node("PersistentSequence", "S", "RRS", current_child_idx="{at}"), at=0)
        assert bench.tick() == "RUNNING A.start=S B.start=R"
        bench.built.halt()
        assert bench.tick() == "RUNNING B.start=R"
        assert bench.built.board["at"] == 1

    def test_pause(self, bench):
        bench.tree(bench.node("PauseResumeController", "R", "R", "S", "S", paused="{p}"), p=False)
        assert bench.tick() == "RUNNING A.start=R"
        bench.built.board["p"] = True
        assert bench.ticks(2) == ["RUNNING A.halt C.start=S", "RUNNING B.start=R"]
        bench.built.board["p"] = False
        assert bench.ticks(2) == ["RUNNING B.halt D.start=S", "RUNNING A.start=R"]
