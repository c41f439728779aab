"""Boards: remapping, privacy, type locks, and values from text."""

from __future__ import annotations

import enum

import pytest
from py_trees.common import Status

from rocs_bt.trees.board import Board
from rocs_bt.trees.error import TreeError
from rocs_bt.trees.status import SKIPPED
from rocs_bt.trees.value import from_string


class Gear(enum.Enum):
    SLOW = 1
    FAST = 7


def boards(autoremap=False, **remapping):
    outer = Board(name="outer")
    inner = Board(outer, autoremap=autoremap, name="inner")
    inner.remapping.update(remapping)
    return outer, inner


def test_a_subtrees_keys_are_its_own():
    outer, inner = boards()
    outer["x"] = 1
    assert "x" not in inner
    inner["x"] = 2
    assert (outer["x"], inner["x"]) == (1, 2)


def test_a_remapped_key_is_the_parents_both_ways():
    outer, inner = boards(goal="dock")
    outer["dock"] = "A"
    assert inner["goal"] == "A"
    inner["goal"] = "B"
    assert outer["dock"] == "B"
    assert inner.resolve("goal") == (outer, "dock")
    assert inner.keys() == []


def test_autoremap_finds_and_makes_all_keys_but_private_ones_at_the_parent():
    outer, inner = boards(autoremap=True)
    outer["x"], outer["_x"] = 1, 2
    inner["y"], inner["_y"] = 3, 4
    assert inner["x"] == 1
    assert "_x" not in inner
    assert (outer.keys(), inner.keys()) == (["_x", "x", "y"], ["_y"])


def test_an_explicit_remapping_wins_over_autoremap():
    outer, inner = boards(autoremap=True, x="y")
    outer["x"], outer["y"] = 1, 2
    assert inner["x"] == 2


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

    def test_text_is_the_universal_donor(self):
        board = Board()
        board["x"] = "5"
        board["x"] = 7
        assert board["x"] == 7
        board["y"] = 1.5
        board["y"] = "2.5"
        assert board["y"] == 2.5

    def test_two_ports_cannot_give_one_key_two_types(self):
        board = Board()
        board.declare("x", int)
        board.declare("x", int)
        with pytest.raises(
            TreeError, match=r"the key 'x' is of type int, not float. The first declaration of a key fixes its type"
        ):
            board.declare("x", float)

    def test_ports_that_take_anything_fix_nothing(self):
        board = Board()
        board.declare("x")
        board["x"] = 1.5
        assert board["x"] == 1.5

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


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("42", int, 42),
        ("-7", int, -7),
        ("RED", int, 3),
        ("1.5", float, 1.5),
        (".5", float, 0.5),
        ("-1e3", float, -1000.0),
        ("inf", float, float("inf")),
        ("true", bool, True),
        ("0", bool, False),
        ("a;b", str, "a;b"),
        ("a;b", list[str], ["a", "b"]),
        ("1;2;3", list[int], [1, 2, 3]),
        ("", list[float], []),
        ("FAST", Gear, Gear.FAST),
        ("7", Gear, Gear.FAST),
        ("SUCCESS", Status, Status.SUCCESS),
        ("IDLE", Status, Status.INVALID),
        ("SKIPPED", Status, SKIPPED),
    ],
)
def test_text_becomes_a_value_of_the_ports_type(text, kind, value):
    found = from_string(text, kind, {"RED": 3})
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("42abc", int),
        (" 4", int),
        ("1.5", int),
        ("1,5", float),
        ("1_0", float),
        ("yes", bool),
        ("3", Gear),
        ("DONE", Status),
        ("1;x", list[int]),
        ("x", object),
    ],
)
def test_what_is_no_such_value_is_refused(text, kind):
    with pytest.raises(TreeError, match=r"is not|unknown status|cannot be converted"):
        from_string(text, kind)
