"""Files that are not a journal, or not whole, or not of this version: told, and never damaged further."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError, RecordingError
from rocs_bt.event import NullSink
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import History, Journal


def journal_at(path: Path, writes: int = 40) -> Path:
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    with Journal(path, "run", keep=30) as journal:
        journal.attach(graph)
        for count in range(writes):
            graph.add(f"o{count}", "object", radius=1.0)
    return path


def test_what_is_no_journal_is_refused_and_left_alone(tmp_path: Path) -> None:
    text, other, empty = tmp_path / "text", tmp_path / "other", tmp_path / "empty"
    text.write_bytes(b"no database" * 1000)
    connection = sqlite3.connect(other)
    connection.execute("CREATE TABLE people (name)")
    connection.close()
    empty.write_bytes(b"")
    for path, why in ((text, "not a database"), (other, "a database of another program")):
        before = path.read_bytes()
        with pytest.raises(RecordingError, match=why):
            History(path)
        with pytest.raises(RecordingError, match=why):
            Journal(path)
        assert path.read_bytes() == before
    with pytest.raises(RecordingError, match="not a rocs_bt journal but an empty database"):
        History(empty)
    Journal(empty).close()  # as a process leaves it that was killed at once
    assert History.runs(empty) == []
    with pytest.raises(InputError, match="there is no run"):
        History(empty)
    with pytest.raises(RecordingError, match=r"there is no knowledge .*run SCENARIO --knowledge"):
        History(tmp_path / "missing")
    with pytest.raises(RecordingError, match="cannot be written"):
        Journal(tmp_path / "missing" / "k.sqlite")


def test_another_format_is_refused(tmp_path: Path) -> None:
    path = journal_at(tmp_path / "k.sqlite")
    connection = sqlite3.connect(path)
    connection.execute("PRAGMA user_version = 1")
    connection.close()
    for opened in (History, Journal):
        with pytest.raises(RecordingError, match="has format 1; this version of rocs_bt reads format 2"):
            opened(path)


def test_names_that_do_not_exist_are_told_with_those_that_do(tmp_path: Path) -> None:
    path = journal_at(tmp_path / "k.sqlite")
    with pytest.raises(InputError, match=r"'R3'.*R2"):
        History(path, "R3")
    with pytest.raises(InputError, match=r"no run 5 .*It has: 1 \(run\)"):
        History(path, run=5)
