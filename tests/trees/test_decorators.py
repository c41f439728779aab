"""Decorators, switches and nodes for navigation, where test_conformance.py has no C++ engine to compare with."""

from __future__ import annotations

import pytest

from rocs_bt.trees.nodes import Tree


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
