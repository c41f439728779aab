"""The journal's thread: it never holds a writer up, loses nothing silently, and tells when the disk fails."""

from __future__ import annotations

import sqlite3
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from rocs_bt.base.clock import SimulatedClock, WallClock
from rocs_bt.base.errors import KnowledgeError, RecordingError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge, KnowledgeGraph
from rocs_bt.knowledge.history import History, Journal, JournalPast

from .worlds import held


def graph_of(agent: str = "R2") -> KnowledgeGraph:
    graph = KnowledgeGraph(WallClock(), NullSink(), agent)
    graph.add("box", "object", radius=0.1)
    return graph


@contextmanager
def disk_that_stands_still(path: Path) -> Iterator[None]:
    """Another process that holds the file: every write of the journal waits."""
    other = sqlite3.connect(path, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    try:
        yield
    finally:
        other.execute("COMMIT")
        other.close()


def test_a_full_queue_loses_moments_and_says_so_but_never_what_is_so(tmp_path: Path) -> None:
    path, graph = tmp_path / "k.sqlite", graph_of()
    with Journal(path, limit=8, every=0.001) as journal:
        journal.attach(graph)
        graph.add("early", "object", radius=1.0)
        journal.flush()
        with disk_that_stands_still(path):
            for count in range(100):  # would last for ever if the writer waited
                graph.set("box", radius=float(count))
            graph.add("late", "object", radius=2.0)
            graph.relate("late", "near", "early", distance=3.0)
            assert journal.lost > 0
        journal.flush()
        graph.set("box", radius=1000.0)
    with History(path) as history:
        assert held(history.as_of()) == held(graph)
        assert history.as_of().revision == graph.revision
        assert history.gaps
        for first, last in history.gaps:  # more than one where the state was taken anew while the disk stood still
            if first < last:  # else only the change is missing, and what it led to is known
                with pytest.raises(KnowledgeError, match=rf"lacks revisions {first} to {last}, which were dropped"):
                    history.as_of(revision=first)
            assert history.as_of(revision=first - 1).get("early", "radius") == 1.0
        first, _ = history.gaps[0]
        assert not history.as_of(revision=first - 1).has("late")


def test_a_time_in_a_gap_is_told_too(tmp_path: Path) -> None:
    clock = SimulatedClock(0.05)
    graph = KnowledgeGraph(clock, NullSink(), "R2")
    graph.add("box", "object")
    path = tmp_path / "k.sqlite"
    with Journal(path, limit=2, every=60.0) as journal:
        journal.attach(graph)
        with disk_that_stands_still(path):
            for count in range(40):
                clock.advance()
                graph.set("box", radius=float(count))
    with History(path) as history:
        *_, before, after = history.stretches
        assert before.end < after.begin
        with pytest.raises(KnowledgeError, match=r"there is no .* s: .* lacks revisions"):
            history.as_of((before.end + after.begin) / 2.0)
        assert history.as_of(before.end).revision == before.last
        assert history.as_of(after.begin).revision >= after.first
        assert history.as_of().get("box", "radius") == 39.0


def test_writes_lost_while_the_state_is_taken_anew_are_made_good(tmp_path: Path) -> None:
    """Many threads that write without a pause through a queue that is nearly always full."""
    path, graph = tmp_path / "k.sqlite", graph_of()
    for count in range(300):  # so that a copy takes longer than many writes
        graph.add(f"fixed {count}", "object", radius=1.0)
        graph.relate(f"fixed {count}", "near", "box")
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with Journal(path, limit=4, every=0.0005) as journal:
            journal.attach(graph)

            def write(who: str) -> None:
                for count in range(300):
                    with graph.locked():
                        graph.add(f"{who} {count}", "object", radius=float(count))
                        graph.relate(f"{who} {count}", "near", "box", distance=1.0)
                        if count >= 3:
                            graph.remove(f"{who} {count - 3}")

            threads = [threading.Thread(target=write, args=(who,)) for who in "abcd"]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            assert journal.lost > 0
    finally:
        sys.setswitchinterval(before)
    with History(path) as history:
        state = history.as_of()
        assert state.revision == graph.revision
        nodes = {n: state.attributes(n) for n in state.nodes()}
        assert nodes == {n: graph.attributes(n) for n in graph.nodes()}
        assert {*state.edges()} == {*graph.edges()}
        for stretch in history.stretches:
            told = [c.revision for c in history.changes(stretch.first, stretch.last)]
            assert told == [*range(stretch.first + 1, stretch.last + 1)]
        for stretch in history.stretches:  # and each base, and the end before each gap, holds whole writes
            for revision in (stretch.first, stretch.last):
                at = history.as_of(revision=revision)
                assert all(at.related(n, "near") == ["box"] for n in at.nodes() if n != "box")


@pytest.mark.parametrize("keep", [1, 2, 3, 4, 1000])
def test_a_node_that_comes_again_has_nothing_of_what_it_had(tmp_path: Path, keep: int) -> None:
    path, graph = tmp_path / "k.sqlite", graph_of()
    with Journal(path, keep=keep) as journal:
        journal.attach(graph)
        graph.remove("box")
        graph.add("box", "object")
        graph.add("last", "object", height=1.0)
    with History(path) as history:
        assert history.value("box", "radius") is None
        assert history.as_of().get("box", "radius") is None
        assert history.value("last", "height") == 1.0


def test_a_patient_journal_makes_writers_wait_and_loses_nothing(tmp_path: Path) -> None:
    path, graph = tmp_path / "k.sqlite", graph_of()
    with Journal(path, limit=4, blocking=True, every=0.001) as journal:
        journal.attach(graph)
        for count in range(500):
            graph.set("box", radius=float(count))
        assert journal.lost == 0
    with History(path) as history:
        assert [c.value for c in history.changes()] == [float(count) for count in range(500)]


def test_a_block_that_is_held_is_written_as_a_whole(tmp_path: Path) -> None:
    path, graph = tmp_path / "k.sqlite", graph_of()
    with Journal(path, every=0.001) as journal:
        journal.attach(graph)
        begin = graph.revision
        with graph.locked():
            for count in range(50):
                graph.set("box", radius=float(count))
                journal.flush()
                with History(path) as history:
                    assert history.last.last == begin
    with History(path) as history:
        assert history.last.last == begin + 50


def test_a_disk_that_is_full_ends_the_journal_and_is_told_and_the_file_stays_good(tmp_path: Path) -> None:
    path, graph = tmp_path / "k.sqlite", graph_of()
    journal = Journal(path, every=60.0, blocking=True, limit=4)
    journal.attach(graph)
    graph.set("box", radius=0.5)
    journal.flush()
    pages = journal._connection.execute("PRAGMA page_count").fetchone()[0]
    journal._connection.execute(f"PRAGMA max_page_count = {pages}")
    for count in range(2000):  # does not hang either, though it is patient
        graph.add(f"o{count}", "object", radius=1.0)
    with pytest.raises(RecordingError, match=r"k\.sqlite' ends early: database or disk is full"):
        journal.close()
    journal.close()
    with History(path) as history:
        assert history.as_of().get("box", "radius") == 0.5


def test_two_agents_share_a_file_and_runs_follow_each_other(tmp_path: Path) -> None:
    path = tmp_path / "k.sqlite"
    for label in ("one", "two"):
        graphs = [graph_of("R2"), graph_of("R3")]
        with Journal(path, label) as journal:
            for graph in graphs:
                journal.attach(graph)
            graphs[1].set("box", radius=len(label) + (label == "two"))
    assert [(e.number, e.agent, e.label) for e in History.runs(path)] == [
        (1, "R2", "one"),
        (1, "R3", "one"),
        (2, "R2", "two"),
        (2, "R3", "two"),
    ]
    with History(path, "R3") as history:
        assert history.as_of().get("box", "radius") == 4.0
    with History(path, "R3", run=1) as history:
        assert history.as_of().get("box", "radius") == 3.0


def test_old_runs_make_room(tmp_path: Path) -> None:
    path = tmp_path / "k.sqlite"
    for count in range(70):
        graph = graph_of()
        with Journal(path, str(count), keep=100) as journal:
            journal.attach(graph)
            for _ in range(30):
                graph.set("box", radius=graph.get("box", "radius") + 1.0)
    kept = History.runs(path)
    assert [e.label for e in kept] == ["66", "67", "68", "69"]
    with sqlite3.connect(path) as connection:
        kept_changes = "SELECT count(*) FROM change JOIN stretch ON id = stretch WHERE place > stretch.revision"
        assert connection.execute(kept_changes).fetchone()[0] == 100
        assert connection.execute("SELECT count(DISTINCT stretch) FROM change").fetchone()[0] == 4
    connection.close()


def test_a_file_stays_as_large_as_it_is(tmp_path: Path) -> None:
    path, graph, sizes = tmp_path / "k.sqlite", graph_of(), []
    with Journal(path, keep=500, every=60.0, blocking=True) as journal:
        journal.attach(graph)
        for _ in range(6):
            for count in range(1000):
                graph.set("box", radius=float(count))
            journal.flush()
            sizes.append(journal._connection.execute("PRAGMA page_count").fetchone()[0])
    assert sizes[-1] == sizes[2]


def test_the_same_writes_give_the_same_file_however_the_thread_ran(tmp_path: Path) -> None:
    def written(name: str, every: float) -> list[tuple[object, ...]]:
        clock = SimulatedClock(0.05)
        graph = KnowledgeGraph(clock, NullSink(), "R2")
        with Journal(tmp_path / name, "run", keep=150, every=every, blocking=True) as journal:
            journal.attach(graph)
            for count in range(100):
                graph.add(f"o{count}", "object", pose=Pose2(count, 0.0))
                graph.relate(f"o{count}", "near", f"o{max(count - 1, 0)}", distance=1.0)
                clock.advance()
        with sqlite3.connect(tmp_path / name) as connection:
            dump = list(connection.iterdump())
        connection.close()
        return [*dump]

    assert written("one", 0.0005) == written("two", 60.0)


def test_the_past_of_a_run_that_goes_on(tmp_path: Path) -> None:
    clock = SimulatedClock(0.05)
    knowledge = Knowledge("R2", clock, NullSink())
    with Journal(tmp_path / "k.sqlite", blocking=True, every=60.0) as journal:
        journal.attach(knowledge.graph)
        knowledge.past = JournalPast(journal, knowledge.graph)
        for count in range(10):
            knowledge.world.place("box", Pose2(count, 0.0), "object")
            clock.advance()
        assert knowledge.past.as_of(0.21).get("box", "pose").x == 4.0
        earlier = knowledge.past.as_of(0.31)  # an answer stays as it is when later ones build on it
        assert knowledge.past.as_of(0.41).get("box", "pose").x == 8.0
        assert earlier.get("box", "pose").x == 6.0
        assert knowledge.past.as_of(0.11).get("box", "pose").x == 2.0
        assert held(knowledge.past.as_of(10.0)) == held(knowledge.past.as_of(0.45))
        knowledge.past.close()


def test_what_was_known_before_is_the_base(tmp_path: Path) -> None:
    graph = graph_of()
    with Journal(tmp_path / "k.sqlite") as journal:
        journal.attach(graph)
        graph.set("box", radius=0.2)
    with History(tmp_path / "k.sqlite") as history:
        assert history.as_of(revision=history.first.first).get("box", "radius") == 0.1
        with pytest.raises(KnowledgeError, match=r"there is no -1 s: .* begins at"):
            history.as_of(-1.0)
        with pytest.raises(KnowledgeError, match=r"there is no revision 99: .* ends at .* s, revision 3"):
            history.as_of(revision=99)
        with pytest.raises(KnowledgeError, match="a time or a revision"):
            history.as_of(1.0, revision=2)
        with pytest.raises(KnowledgeError, match="no node named 'bxo'"):
            history.value("bxo", "radius")
        with pytest.raises(KnowledgeError, match="radius"):
            history.value("box", "radios")
