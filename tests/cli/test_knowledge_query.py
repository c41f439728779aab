"""`rocs-bt knowledge query`: of a run, of a file of knowledge, of an export."""

import json
from pathlib import Path

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.cli.main import call
from rocs_bt.event import SignalsWritten, pack
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.record import AgentInfo, RunHeader
from rocs_bt.record.file.header import SignalInfo
from rocs_bt.record.file.recorder import Recorder

SIGNALS = (SignalInfo(name="charge"), SignalInfo(name="pose", size=3, units=("m", "m", "rad")))
HEADER = RunHeader(scenario="yard", seed=1, agents=(AgentInfo(name="R2", robot="", mission="", signals=SIGNALS),))


@pytest.fixture
def kept(tmp_path):
    clock, recorder = SimulatedClock(0.05), Recorder(tmp_path / "run.mcap", HEADER)
    graph = KnowledgeGraph(clock, recorder, "R2")
    graph.add("box", "object", pose=Pose2(1.0, 0.0), moves=True)
    clock.advance(20)
    graph.set("box", moves=False, pose=Pose2(3.0, 0.0))
    graph.add("anna", "person", pose=Pose2(2.0, 0.0))
    recorder.close()
    return str(tmp_path / "run.mcap")


def test_answers_are_a_table_or_json(kept, capsys):
    assert call(["knowledge", "query", kept, "object give pose, moves"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "object  pose       moves",
        "anna    (2, 0, 0)  unknown",
        "box     (3, 0, 0)  no",
    ]
    assert call(["knowledge", "query", kept, "object where object == 'box' give pose", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == [{"object": "box", "pose": [3.0, 0.0, 0.0]}]


def test_as_of_an_earlier_time(kept, capsys):
    for arguments in (["object where moves", "--at", "0.5"], ["object where moves as of 0.5 s"]):
        assert call(["knowledge", "query", kept, *arguments]) == 0
        assert capsys.readouterr().out.split() == ["object", "box"]


def test_no_answer_and_no_query(kept, capsys):
    assert call(["knowledge", "query", kept, "goal"]) == 1
    assert capsys.readouterr().out == "no answers.\n"
    assert call(["knowledge", "query", kept, "where distance('box', 'anna') < 2 m"]) == 0
    assert capsys.readouterr().out == "yes.\n"
    assert call(["knowledge", "query", kept, "object whre moves"]) == 2
    assert "query:1:8: there is no relation named 'whre'" in capsys.readouterr().err


def test_a_query_of_a_run_may_use_the_robots_pose_and_its_signals(kept, capsys):
    recorder = Recorder(Path(kept), HEADER)
    KnowledgeGraph(SimulatedClock(0.05), recorder, "R2").add("box", "object", pose=Pose2(3.0, 4.0))
    for t, charge in ((0.0, 0.1), (1.0, 0.7)):
        data = pack([charge, 3.0, 4.0 * t, 0.0])
        recorder.emit(SignalsWritten(t=t, agent="R2", monitor="m", signals=("charge", "pose"), sizes=(1, 3), data=data))
    recorder.close()
    for t, row in (("0.1", "box 4"), ("1", "box 0")):
        assert call(["knowledge", "query", kept, "object where charge < 1 give distance(object)", "--at", t]) == 0
        assert capsys.readouterr().out.splitlines()[1].split() == row.split()
    assert call(["knowledge", "query", kept, "object where charge > 0.5", "--at", "0.5"]) == 1
