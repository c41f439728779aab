"""A block that raises, in lockstep: the wheels stop first, then the run says which block and why."""

import os
import signal
import subprocess
import sys
from dataclasses import dataclass

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from rocs_bt.action import AtomicAction, Progress
from rocs_bt.analyze import PassRange
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.event import AgentStopped, BlockFailed, TicketChanged
from rocs_bt.monitor import RangeMonitor
from rocs_bt.reactive import ReactiveModel
from rocs_bt.record import Recording
from rocs_bt.simulation import replay

AT = 2.0  # [s]


class Rotten(RuntimeError):
    """What the blocks here raise."""


class Leaf(Behaviour):
    """A leaf that raises when its time has come."""

    def __init__(self, mission, error):
        super().__init__("Leaf")
        self.mission, self.error = mission, error

    def update(self):
        if self.mission.clock.now() >= AT:
            raise self.error
        return Status.RUNNING


class Reflex(ReactiveModel):
    """A reactive model that raises when its time has come."""

    def react(self, x, t):
        if t >= AT:
            raise Rotten("a worm")
        return []


@dataclass(kw_only=True, eq=False)
class Rot(AtomicAction):
    """An action that drives, and raises when its time has come, or later while a reflex acts."""

    def act(self, body):
        if body.clock.now() >= AT:
            raise Rotten("a worm")
        body.wheels.command([0.3, 0.3])
        return Progress.RUNNING


def beside(mission, leaf):
    return Parallel("both", ParallelPolicy.SuccessOnAll(synchronise=False), [mission.act("GoTo", goal="goal"), leaf])


def raising(cls, method, clock):
    """A method that raises when its time has come."""
    sound = getattr(cls, method)

    def broken(self, *args):
        if clock().now() >= AT:
            raise Rotten("a worm")
        return sound(self, *args)

    return broken


def rotten_reflex(mission):
    mission.knowledge.reactive_models.append(Reflex())
    return mission.act("GoTo", goal="goal")


@pytest.mark.parametrize("block", ["monitor range", "analyze obstacle", "plan", "reflexes", "execute"])
def test_a_block_that_raises_stops_the_wheels_and_is_named(block, broken, monkeypatch, tmp_path):
    stages = []
    missions = {
        "plan": lambda mission: beside(mission, Leaf(mission, Rotten("a worm"))),
        "reflexes": rotten_reflex,
        "execute": lambda mission: mission.act("Rot"),
    }
    blocks = {"monitor range": (RangeMonitor, "interpret"), "analyze obstacle": (PassRange, "process")}
    if block in blocks:
        cls, method = blocks[block]
        monkeypatch.setattr(cls, method, raising(cls, method, lambda: stages[0].clock))
    run = broken(
        stages.append, missions={"R2": missions[block]} if block in missions else None, out=tmp_path, duration=20.0
    )
    assert run.agent["outcome"] == "error"
    assert f"block 'R2/{block}' raised: Rotten: a worm" in run.agent["reason"]
    assert run.driven == [False]
    assert AT <= run.result.summary["sim_time"] < AT + 2.0
    assert run.coast() < 0.02
    (failed,) = run.of(BlockFailed)
    states = {e.ticket: e.state for e in run.of(TicketChanged)}
    assert set(states.values()) <= {"SUCCEEDED", "FAILED", "CANCELLED"}  # every ticket ended
    recording = Recording.open(tmp_path)
    assert recording.complete
    assert [e for e in recording.events() if isinstance(e, BlockFailed)] == [failed]


def test_a_block_that_calls_for_an_exit_has_ended(broken):
    run = broken(missions={"R2": lambda mission: beside(mission, Leaf(mission, SystemExit(7)))})
    assert run.agent["outcome"] == "error"
    assert "block 'R2/plan' ended: it called for an exit (7)" in run.agent["reason"]
    assert run.driven == [False]


def test_on_the_command_line_it_is_the_engine_that_failed(monkeypatch, tmp_path, capsys):
    def rotten(self, readings):
        raise Rotten("a worm")

    monkeypatch.setattr(RangeMonitor, "interpret", rotten)
    assert call(["run", "exp1", "--out", str(tmp_path), "--no-report"]) == 3
    shown = capsys.readouterr().out
    assert "R2 error" in shown
    assert "monitor range" in shown
    assert "Rotten: a worm" in shown


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kill -9 is there on POSIX only")
def test_a_run_killed_half_way_leaves_a_recording_that_replays(tmp_path, capsys):
    code = (
        "import os, signal, sys\n"
        "from rocs_bt.simulation import run\n"
        "def watch(t):\n"
        "    if t >= 6.0: os.kill(os.getpid(), signal.SIGKILL)\n"
        "run('exp1', out=sys.argv[1], progress=watch)\n"
    )
    killed = subprocess.run([sys.executable, "-c", code, str(tmp_path)], env={**os.environ}, timeout=120, check=False)
    assert killed.returncode == -signal.SIGKILL
    recording = Recording.open(tmp_path)
    assert not recording.complete
    events = list(recording.events())
    assert 5.0 < events[-1].t <= 6.0
    assert not [e for e in events if isinstance(e, AgentStopped)]
    assert replay(recording, Catalog()) is None
    assert call(["replay", str(tmp_path)]) == 0
    assert "cut off" in capsys.readouterr().out
    assert call(["replay", str(tmp_path), "--why", "4.5"]) == 0
    assert "4.5" in capsys.readouterr().out
