"""A leaf that raises: the mission goes on at this leaf, and the command line names its line."""

import json

import pytest
from py_trees.common import Status
from py_trees.composites import Sequence as StockSequence

from rocs_bt.cli.main import call
from rocs_bt.event import NodeTicked
from rocs_bt.trees.nodes import Leaf

from ..direct_project import drive_straight
from ..pages import data_of, log_of
from .test_content import Rotten


class Step(Leaf):
    """A leaf that is done at once, and counts."""

    def __init__(self, name, log):
        super().__init__(name)
        self.log = log

    def update(self):
        self.log.append(self.name)
        return Status.SUCCESS


class Stumbles(Leaf):
    """A leaf that raises in one of its methods, once."""

    def __init__(self, name, log, method, error=None):
        super().__init__(name)
        self.log, self.method, self.error = log, method, error or Rotten("a worm")

    def _at(self, method):
        self.log.append(f"{self.name} {method}")
        if self.method == method:
            self.method = ""
            raise self.error

    def initialise(self):
        self._at("initialise")

    def update(self):
        self._at("update")
        return Status.SUCCESS

    def terminate(self, new_status):
        self._at("terminate")


@pytest.mark.parametrize(
    ("method", "then"),
    [
        ("initialise", ["initialise", "initialise", "update", "terminate"]),
        ("update", ["initialise", "update", "initialise", "update", "terminate"]),
        ("terminate", ["initialise", "update", "terminate", "initialise", "update", "terminate"]),
    ],
)
@pytest.mark.parametrize(
    ("kind", "error"), [("ours", Rotten("a worm")), ("ours", SystemExit(7)), ("theirs", Rotten("a worm"))]
)
def test_a_mission_goes_on_at_the_leaf_that_raised(kind, method, then, error, broken):
    log = []

    def build(mission):
        leaves = [Step("first", log), Stumbles("second", log, method, error), Step("third", log)]
        if kind == "theirs":
            return StockSequence("root", True, leaves)
        return mission.node("Sequence", *leaves, name="root")

    run = broken(missions={"R2": build}, rules=(), duration=1.0)
    again = [f"second {method}" for method in then]
    assert log == ["first", *again, "third"]
    assert run.agent.exceptions == {"leaf root/second": 1}
    assert [e.status for e in run.of(NodeTicked) if e.node == "root"] == ["RUNNING", "SUCCESS"]


MISSION = """
import json

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from rocs_bt import Mission
from rocs_bt.base.units import PositiveMetresPerSecond


class Camera(Behaviour):
    def __init__(self, mission):
        super().__init__("camera")
        self.mission = mission

    def update(self):
        if self.mission.clock.now() > 1.0:
            json.loads("{")
        return Status.RUNNING


def build(mission: Mission, *, first: str, second: str, cruise: PositiveMetresPerSecond = 0.4):
    return Parallel("both", ParallelPolicy.SuccessOnOne(), [mission.act("GoTo", goal=first), Camera(mission)])
"""


def test_on_the_command_line_the_line_of_content_is_named(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert call(["new", "mine"]) == 0
    drive_straight(tmp_path / "mine")
    monkeypatch.chdir(tmp_path / "mine")
    (tmp_path / "mine/planners/missions/patrol.py").write_text(MISSION)
    capsys.readouterr()
    assert call(["run", "first"]) == 1
    shown = capsys.readouterr().out
    raised = (
        "leaf 'both/camera' raised JSONDecodeError: Expecting property name enclosed in double quotes: "
        "line 1 column 2 (char 1) (patrol.py:19); "
    )
    assert f"R1 failed (first, seed 1): the mission failed: {raised}3 exceptions within 10 s\n" in shown
    assert f"  fault at 1.10 s: {raised}brakes and replans (1 of 3 within 10 s)\n" in shown
    summary = json.loads((tmp_path / "mine/runs/first-1/summary.json").read_text())
    assert summary["agents"]["R1"]["exceptions"] == {"leaf both/camera": 3}
    page = tmp_path / "mine/runs/first-1/report.html"
    assert f"{raised}brakes and replans (2 of 3 within 10 s)" in log_of(page)
    assert ["exceptions of content", "3"] in data_of(page)["results"]["R1"]["numbers"]
    assert call(["replay", "runs/first-1", "--why", "1.12"]) == 0
    why = capsys.readouterr().out
    assert "raised       leaf 'both/camera' raised JSONDecodeError" in why
    assert "(1 of 3 within 10 s), 0.02 s ago" in why
