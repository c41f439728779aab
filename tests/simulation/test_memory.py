"""Knowledge between runs: what a run leaves is there in the next, and keeping it changes nothing of a run."""

from __future__ import annotations

import math
import signal
from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError, RecordingError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.event import NullSink
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import GraphState, read_knowledge, to_json_text
from rocs_bt.record import Recording
from rocs_bt.record.knowledge import recorded_log
from rocs_bt.running.replay import replay
from rocs_bt.running.stop_signals import EndedAtOnce

from ..knowledge.history.worlds import held

SECONDS = 3.0


def remembered(path: Path) -> None:
    """A file in which R2 knows a dock and a shelf from an earlier run, and things that do not last; and an R9."""
    graph, other = (KnowledgeGraph(SimulatedClock(0.05), NullSink(), name) for name in ("R2", "R9"))
    graph.add("R2", "robot", mode="patrol")
    graph.add("dock", "place", pose=Pose2(1.0, 2.0))
    graph.add("shelf", "object", pose=Pose2(0.5, 0.5), radius=math.inf)
    graph.add("R1", "peer", pose=Pose2(0.0, 0.0))
    graph.add("goal", "place", pose=Pose2(0.0, 0.0))
    graph.relate("shelf", "near", "dock", distance=1.5)
    other.add("den", "place", pose=Pose2(5.0, 5.0))
    path.write_text(to_json_text(GraphState.of(graph), GraphState.of(other)), "utf-8")


def events(folder: Path) -> list[object]:
    """What happened in a run, but for times that a wall clock gave."""
    return [e for e in Recording.open(folder).events() if type(e).__name__ != "FollowerStepped"]


def test_a_run_is_the_same_to_the_bit_whether_its_knowledge_is_kept_or_not(tmp_path: Path) -> None:
    catalog, file = Catalog(), tmp_path / "deep" / "k.json"
    plain = run("exp1", catalog, duration=SECONDS, out=tmp_path / "plain", report=False)
    kept = run("exp1", catalog, duration=SECONDS, out=tmp_path / "kept", report=False, knowledge=file)
    assert kept.summary.trajectory_hash == plain.summary.trajectory_hash
    assert events(tmp_path / "kept") == events(tmp_path / "plain")
    assert not plain.summary.knowledge
    assert '"knowledge"' not in plain.summary.to_json()
    end = recorded_log(Recording.open(tmp_path / "plain")).as_of()
    assert held(read_knowledge(file)["R2"]) == held(end)


def test_the_next_run_knows_what_lasts_of_the_one_before_and_can_be_replayed(tmp_path: Path) -> None:
    file, catalog = tmp_path / "k.json", Catalog()
    remembered(file)
    result = run("exp1", catalog, duration=SECONDS, out=tmp_path / "run", report=False, knowledge=file)
    (told,) = result.summary.knowledge.remembered.values()
    assert (told.nodes, told.edges) == (2, 1)
    assert ["'goal' was of kind place" in reason for reason in told.refused] == [True]
    states = read_knowledge(file)
    for state in (recorded_log(Recording.open(tmp_path / "run")).as_of(0.0), states["R2"]):
        assert state.get("shelf", "radius") == math.inf
        assert state.edge("shelf", "near", "dock") == {"distance": 1.5}
        assert state.get("R2", "mode") is None
        assert not state.has("R1") or state.get("R1", "pose") is None
    assert states["R9"].get("den", "pose") == Pose2(5.0, 5.0), "who is not in this run keeps its knowledge"
    assert replay(Recording.open(tmp_path / "run"), catalog) is None
    again = run("exp1", catalog, duration=SECONDS, knowledge=file)  # and the one after it
    assert again.summary.knowledge.remembered["R2"].nodes == 2
    assert again.summary.trajectory_hash == result.summary.trajectory_hash


@pytest.mark.usefixtures("awake")
def test_a_threaded_run_keeps_its_knowledge_too(tmp_path: Path) -> None:
    file = tmp_path / "k.json"
    run("exp1", Catalog(), mode="threaded", duration=0.5, knowledge=file)
    assert read_knowledge(file)["R2"].kind("R2") == "robot"


@pytest.mark.parametrize("error", [OSError("the sink broke"), KeyboardInterrupt(), EndedAtOnce(signal.SIGTERM)])
def test_a_run_that_is_cut_off_keeps_what_it_knows(tmp_path: Path, error: BaseException) -> None:
    file = tmp_path / "k.json"
    remembered(file)

    def break_off(t: float) -> None:
        if t > 0.5:
            raise error

    with pytest.raises(type(error)):
        run("exp1", Catalog(), duration=SECONDS, knowledge=file, progress=break_off)
    state = read_knowledge(file)["R2"]
    assert state.kind("goal") == "goal"
    assert state.has("shelf")
    assert state.t > 0.5


def test_a_file_that_cannot_be_written_is_refused_before_anything_is_replaced(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="it is a folder"):
        run("exp1", Catalog(), duration=0.3, out=tmp_path / "run", knowledge=tmp_path)
    assert not (tmp_path / "run").exists()


def test_a_file_that_is_broken_meanwhile_stays_as_it_is_and_the_run_says_so(tmp_path: Path) -> None:
    file = tmp_path / "k.json"
    result = run("exp1", Catalog(), duration=0.3, knowledge=file, progress=lambda t: file.write_text("[") and None)
    assert file.read_text() == "["
    assert any("k.json' is not written: " in missing for missing in result.missing)


@pytest.mark.parametrize(
    ("text", "told"), [("no knowledge", r"notes\.json:1:1: this is not valid JSON"), ("{}", "there is no 'agents'")]
)
def test_a_file_of_something_else_refuses_the_run_before_it_begins(tmp_path: Path, text: str, told: str) -> None:
    other = tmp_path / "notes.json"
    other.write_text(text)
    with pytest.raises(InputError, match=told):
        run("exp1", Catalog(), duration=SECONDS, out=tmp_path / "run", knowledge=other)
    assert not (tmp_path / "run").exists()
    assert other.read_text() == text
