"""Boards: remapping, privacy, type locks, and values from text."""

from __future__ import annotations

import pytest

from rocs_bt.trees.board import Board
from rocs_bt.trees.error import TreeError


def boards(autoremap=False, **remapping):
    outer = Board(name="outer")
    inner = Board(outer, autoremap=autoremap, name="inner")
    inner.remapping.update(remapping)
    return outer, inner


def test_a_remapped_key_is_the_parents_both_ways():
    outer, inner = boards(goal="dock")
    outer["dock"] = "A"
    assert inner["goal"] == "A"
    inner["goal"] = "B"
    assert outer["dock"] == "B"
    assert inner.resolve("goal") == (outer, "dock")
    assert inner.keys() == []


def test_the_global_key_is_the_roots_at_any_depth():
    outer, inner = boards()
    deep = Board(inner)
    deep["@g"] = 5
    assert (outer["g"], inner["@g"], outer["@g"]) == (5, 5, 5)
    assert "g" not in deep
    with pytest.raises(TreeError, match="more than one '@'"):
        deep.resolve("@a@b")


def test_unset_removes_only_what_is_this_boards():
    outer, inner = boards(autoremap=True)
    outer["x"] = 1
    inner.unset("x")
    assert outer["x"] == 1
    entry = outer.entry("x")
    inner.unset("@x")
    assert "x" not in outer
    assert not entry.alive


class TestTypes:
    def test_the_first_typed_value_fixes_the_type(self):
        board = Board()
        board["x"] = 1
        with pytest.raises(TreeError, match=r"the key 'x' is of type int, and 2.5 does not fit"):
            board["x"] = 2.5
        board["x"] = 3.0  # nothing is lost
        assert board["x"] == 3
        assert isinstance(board["x"], int)

    def test_two_ports_cannot_give_one_key_two_types(self):
        board = Board()
        board.declare("x", int)
        board.declare("x", int)
        with pytest.raises(
            TreeError, match=r"the key 'x' is of type int, not float. The first declaration of a key fixes its type"
        ):
            board.declare("x", float)

    def test_every_write_is_counted(self):
        board = Board()
        for value in (1, 1, 2):
            board["x"] = value
        assert board.entry("x").sequence == 3

    def test_what_is_not_there_is_told_with_what_is(self):
        board = Board()
        board["goal"] = 1
        with pytest.raises(TreeError, match=r"no value at 'gaol'. Did you mean 'goal'"):
            board["gaol"]
