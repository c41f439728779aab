"""kill -9 at random moments: the file opens to a state that was, and misses no write that was flushed."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import RecordingError
from rocs_bt.event import NullSink
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import History, Journal, State


def kill_one(path: Path, moment: random.Random, keep: int) -> int:
    """Start the writer, kill it at a random moment, and check what it left; the last write that was told flushed."""
    command = [sys.executable, str(Path(__file__).with_name("killed.py")), str(path), str(keep)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        first = process.stdout.readline()
        assert first, process.stderr.read()
        time.sleep(moment.uniform(0.0, 0.15))
        process.kill()
        told = [first, *process.stdout.readlines()]
    flushed = int(next(line for line in reversed(told) if line.endswith("\n")))
    with History(path) as history:
        newest = check_whole(history.as_of())
        assert newest >= flushed
        for revision in sorted({history.first.first, *moment.sample(range(history.first.first, history.last.last), 5)}):
            history.as_of(revision=revision)
        assert history.last.last - history.first.first <= keep
    return flushed


def check_whole(state: State) -> int:
    """That no write is there by half; the newest write."""
    seen = {int(name[1:]) for name in state.nodes("object")}
    newest = max(seen)
    assert seen == set(range(newest - 4, newest + 1))
    for count in seen:
        assert state.attributes(f"a{count}")["radius"] == state.attributes(f"b{count}")["radius"] == float(count)
        assert state.edge(f"a{count}", "near", f"b{count}") == {"distance": float(count)}
    return newest


@pytest.mark.parametrize("keep", [100, 100_000])
def test_a_killed_process_leaves_whole_writes(tmp_path: Path, keep: int) -> None:
    moment = random.Random(keep)
    for count in range(2):
        kill_one(tmp_path / f"{count}.sqlite", moment, keep)


@pytest.mark.soak
def test_a_hundred_killed_processes_leave_whole_writes(tmp_path: Path) -> None:
    moment = random.Random(6)
    for count in range(100):
        kill_one(tmp_path / f"{count}.sqlite", moment, moment.choice((50, 1000, 100_000)))


def test_the_next_run_goes_on_in_the_file_of_a_killed_one(tmp_path: Path) -> None:
    path, moment = tmp_path / "k.sqlite", random.Random(1)
    kill_one(path, moment, 100_000)
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    with Journal(path, "after", blocking=True) as journal:
        journal.attach(graph)
        graph.add("later", "object")
    with History(path) as history:
        assert history.entry.label == "after"
        assert history.as_of().nodes() == ["later"]
    with History(path, run=history.entry.number - 1) as history:
        check_whole(history.as_of())


def test_a_file_cut_in_the_middle_is_told(tmp_path: Path) -> None:
    path = tmp_path / "k.sqlite"
    kill_one(path, random.Random(2), 100_000)
    with Journal(path, blocking=True):
        pass  # the write-ahead log is moved into the file
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2 + 100])
    with pytest.raises(RecordingError, match=r"damaged|cannot be read"), History(path) as history:
        history.as_of()
