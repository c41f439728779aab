"""Setting values in a TOML text: each way to write a table, with comments, order and the rest of the text unchanged."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path

import numpy as np
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.toml_edit import with_values

FILE = Path("robot.toml")
VALUES = {("move", "delay"): "0.4 s", ("move", "lag"): "0.01 s", ("move", "vx", "brake"): "1 m/s2"}

FIRST = ["", "# a comment\nx = 1\n", 'format = "f/1"', "[other]\nlag = 3\n", '[[list]]\nname = "a"\nmove.lag = 1\n']
TABLES = [
    "",
    "[move]\n",
    '[move]\nlag = "1 s"   # by the data sheet\n',
    '[move]\nlag = "1 s"\n\n# of the axis\n[move.vx]\ntop = [1,\n 2] # two\n',
    '[move]\nvx.top = "1"  # c\nlag = 2\n',
    '[move.vx]\nbrake = "3"\n',
    'move = { lag = "1 s", vx = { top = 2 } }  # one line\n',
    "move = {}\n",
    'move.lag = "0"\nmove.vx.top = "3"\n',
    '[ \'move\' ]\n"lag" = """1 s"""\n',
]
LAST = ["", "\n[last]\nmove = 1\n", '\n[[list]]\nname = "b"\n[list.move]\nlag = "2"  # of the list\n']


def texts() -> list[str]:
    """Every table after every beginning in which it is a table of the root, and before every end."""
    found = []
    for first in FIRST:
        for table in TABLES:
            if table.startswith("move") and "[" in first:
                continue
            found += [(first if first.endswith("\n") or not first else first + "\n") + table + last for last in LAST]
    return found


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_values_are_set_and_nothing_else_changes(newline: str) -> None:
    for text in texts():
        text = text.replace("\n", newline)
        new = with_values(text, VALUES, FILE, "measured")
        data = tomllib.loads(text)
        move = data.setdefault("move", {})
        move |= {"delay": "0.4 s", "lag": "0.01 s"}
        move.setdefault("vx", {})["brake"] = "1 m/s2"
        assert tomllib.loads(new) == data, text
        assert newline not in text or new.count("\n") == new.count(newline)
        gone = [line for line in difflib.ndiff(text.split(newline), new.split(newline)) if line.startswith("- ")]
        assert all("lag" in line or "brake" in line or "move" in line or "vx" in line for line in gone if line[2:])
        assert [c.partition("#")[2] for c in text.splitlines() if "#" in c] == [
            c.partition("#")[2] for c in new.splitlines() if "#" in c and "# measured" not in c
        ]


def test_setting_what_is_set_changes_nothing() -> None:
    for text in texts():
        once = with_values(text, VALUES, FILE, "measured")
        assert with_values(once, VALUES, FILE, "measured") == once


def test_a_replaced_value_keeps_comment_and_column() -> None:
    text = '[move]\nlag = "0.0131 s"  # here\ndelay = 0      # there\n'
    new = with_values(text, {("move", "lag"): "0.2 s", ("move", "delay"): "1 s"}, FILE, "")
    assert new == '[move]\nlag = "0.2 s"     # here\ndelay = "1 s"  # there\n'


def test_a_new_value_is_at_the_end_of_its_table_before_the_blank_line() -> None:
    new = with_values("[move]\na = 1\n\n[x]\n", {("move", "lag"): "1 s"}, FILE, "measured")
    assert new == '[move]\na = 1\nlag = "1 s"                       # measured\n\n[x]\n'


def test_what_cannot_be_set_is_an_error_that_names_it() -> None:
    with pytest.raises(InputError, match=r'cannot write lag = "1 s" into \[move\]. Write it by hand'):
        with_values("[[move]]\na = 1\n", {("move", "lag"): "1 s"}, FILE, "")


def test_any_order_of_keys_gives_the_same_data() -> None:
    random = np.random.default_rng(7)
    for text in texts():
        items = list(VALUES.items())
        random.shuffle(items)
        new = with_values(text, dict(items), FILE, "measured")
        assert tomllib.loads(new) == tomllib.loads(with_values(text, VALUES, FILE, "measured"))
