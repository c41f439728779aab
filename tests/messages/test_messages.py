"""Every message of the golden table is read as it is written there."""

from __future__ import annotations

import difflib

import pytest

from .table import heads, play, rows, text_of


@pytest.mark.parametrize("group", heads())
def test_messages_are_those_of_the_table(group):
    table = [row for row in rows() if row.group == group]
    expected, found = text_of(table), text_of(play(table))
    diff = difflib.unified_diff(expected.splitlines(), found.splitlines(), "expected", "found", lineterm="", n=4)
    assert found == expected, "\n".join(["messages changed (python -m tests.messages.table):", *diff])
