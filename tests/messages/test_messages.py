"""Every message of the golden table is read as it is written there."""

from __future__ import annotations

import difflib

from .table import FILE, play, rows, written


def test_messages_are_those_of_the_table():
    found = written(play(rows()))
    expected = FILE.read_text(encoding="utf-8")
    diff = difflib.unified_diff(expected.splitlines(), found.splitlines(), "expected", "found", lineterm="", n=4)
    assert found == expected, "\n".join(["messages changed (python -m tests.messages.table):", *diff])
