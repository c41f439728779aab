"""Knowledge between runs: what a run leaves is there in the next, and keeping it changes nothing of a run."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import RecordingError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.event import KnowledgeChanged, NullSink
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import History, State, write_state
from rocs_bt.record import Recording
from rocs_bt.running.replay import replay

SECONDS = 3.0


def remembered(path: Path) -> None:
    """A file in which R2 knows a dock and a shelf from an earlier run, and things that do not last."""
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    graph.add("R2", "robot", mode="patrol")
    graph.add("dock", "place", pose=Pose2(1.0, 2.0))
    graph.add("shelf", "object", pose=Pose2(0.5, 0.5), radius=math.inf)
    graph.add("R1", "peer", pose=Pose2(0.0, 0.0))
    graph.add("goal", "place", pose=Pose2(0.0, 0.0))
    graph.relate("shelf", "near", "dock", distance=1.5)
    write_state(path, State.of(graph), "earlier")


def events(folder: Path) -> list[object]:
    """What happened in a run, but for times that a wall clock gave."""
    return [e for e in Recording.open(folder).events() if type(e).__name__ != "FollowerStepped"]


def test_a_run_is_the_same_to_the_bit_whether_its_knowledge_is_kept_or_not(tmp_path: Path) -> None:
    catalog = Catalog()
    plain = run("exp1", catalog, duration=SECONDS, out=tmp_path / "plain", report=False)
    kept = run("exp1", catalog, duration=SECONDS, out=tmp_path / "kept", report=False, knowledge=tmp_path / "k.sqlite")
    assert kept.summary.trajectory_hash == plain.summary.trajectory_hash
    assert events(tmp_path / "kept") == events(tmp_path / "plain")
    assert not plain.summary.knowledge
    assert '"knowledge"' not in plain.summary.to_json()
    told = [e for e in events(tmp_path / "plain") if isinstance(e, KnowledgeChanged)]
    with History(tmp_path / "k.sqlite", "R2") as history:
        assert history.entry.label == "exp1-1"
        assert list(history.changes()) == [e for e in told if e.revision > history.first.first]


def test_the_next_run_knows_what_lasts_of_the_one_before_and_can_be_replayed(tmp_path: Path) -> None:
    file, catalog = tmp_path / "k.sqlite", Catalog()
    remembered(file)
    result = run("exp1", catalog, duration=SECONDS, out=tmp_path / "run", report=False, knowledge=file)
    (told,) = result.summary.knowledge.remembered.values()
    assert (told.nodes, told.edges) == (2, 1)
    assert ["'goal' was of kind place" in reason for reason in told.refused] == [True]
    assert result.summary.knowledge.lost == 0
    with History(file, "R2") as history:
        assert history.entry.label == "exp1-1"
        begin, end = history.as_of(revision=history.first.first), history.as_of()
    for state in (begin, end):
        assert state.get("shelf", "radius") == math.inf
        assert state.edge("shelf", "near", "dock") == {"distance": 1.5}
        assert state.get("R2", "mode") is None
        assert state.get("R1", "pose") is None
    assert replay(Recording.open(tmp_path / "run"), catalog) is None
    again = run("exp1", catalog, duration=SECONDS, knowledge=file)  # and the one after it
    assert again.summary.knowledge.remembered["R2"].nodes == 2
    assert again.summary.trajectory_hash == result.summary.trajectory_hash


@pytest.mark.usefixtures("awake")
def test_a_threaded_run_keeps_its_knowledge_too(tmp_path: Path) -> None:
    file = tmp_path / "deep" / "k.sqlite"
    result = run("exp1", Catalog(), mode="threaded", duration=0.5, knowledge=file)
    assert result.summary.knowledge.lost == 0
    with History(file, "R2") as history:
        assert history.as_of().kind("R2") == "robot"


def test_a_file_of_something_else_refuses_the_run_before_it_begins(tmp_path: Path) -> None:
    other = tmp_path / "notes.txt"
    other.write_text("no knowledge " * 100)
    with pytest.raises(RecordingError, match="not a database"):
        run("exp1", Catalog(), duration=SECONDS, out=tmp_path / "run", knowledge=other)
    assert not (tmp_path / "run").exists()
