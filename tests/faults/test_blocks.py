"""A block that raises, in lockstep: the wheels stop first, then the run says which block and why."""

import os
import signal
import subprocess
import sys

import pytest

from rocs_bt.analyze import PassRange
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.event import AgentStopped, BlockFailed, TicketChanged
from rocs_bt.interfaces.pipeline import Pipeline
from rocs_bt.plan import TreePlan
from rocs_bt.reactive import RuleModel
from rocs_bt.record import Recording
from rocs_bt.running import replay

from .. import needs

AT = 2.0  # [s]


class Rotten(RuntimeError):
    """What the blocks here raise."""


def raising(cls, method, clock, error=None):
    """A method that raises when its time has come."""
    sound = getattr(cls, method)

    def broken(self, *args):
        if clock().now() >= AT:
            raise error or Rotten("a worm")
        return sound(self, *args)

    return broken


@pytest.mark.parametrize("block", ["analyze obstacle", "plan", "reflexes", "execute"])
def test_a_block_that_raises_stops_the_wheels_and_is_named(block, broken, monkeypatch, tmp_path):
    stages = []
    # Of each block what is the engine's own, and no content takes part in.
    cls, method = {
        "analyze obstacle": (PassRange, "process"),
        "plan": (TreePlan, "run"),
        "reflexes": (RuleModel, "react"),
        "execute": (Pipeline, "top"),
    }[block]
    monkeypatch.setattr(cls, method, raising(cls, method, lambda: stages[0].clock))
    run = broken(stages.append, out=tmp_path, duration=20.0)
    assert run.agent.outcome == "error"
    assert f"block 'R2/{block}' raised: Rotten: a worm (test_blocks.py:" in run.agent.reason
    assert run.agent.failed_block == block
    assert run.driven == [False]
    assert AT <= run.result.summary.sim_time < AT + 2.0
    assert run.coast() < 0.02
    (failed,) = run.of(BlockFailed)
    states = {e.ticket: e.state for e in run.of(TicketChanged)}
    assert set(states.values()) <= {"SUCCEEDED", "FAILED", "CANCELLED"}  # every ticket ended
    recording = Recording.open(tmp_path)
    assert recording.complete
    assert [e for e in recording.events() if isinstance(e, BlockFailed)] == [failed]


def test_a_block_that_calls_for_an_exit_has_ended(broken, monkeypatch):
    stages = []
    monkeypatch.setattr(PassRange, "process", raising(PassRange, "process", lambda: stages[0].clock, SystemExit(7)))
    run = broken(stages.append)
    assert run.agent.outcome == "error"
    assert "block 'R2/analyze obstacle' ended: it raised SystemExit(7)" in run.agent.reason
    assert run.driven == [False]


def test_on_the_command_line_the_engine_failed_and_the_run_is_told_all_the_same(monkeypatch, tmp_path, capsys):
    def rotten(self, samples):
        raise Rotten("a worm")

    monkeypatch.setattr(PassRange, "process", rotten)
    assert call(["run", "exp1", "--out", str(tmp_path), "--no-report"]) == 3
    shown = capsys.readouterr().out
    assert "R2 error" in shown
    assert "block 'R2/analyze obstacle' raised" in shown
    assert "Rotten: a worm" in shown


@needs.posix("has no kill -9")
def test_a_run_killed_half_way_leaves_a_recording_that_replays(tmp_path, capsys):
    code = (
        "import os, signal, sys\n"
        "from rocs_bt import run\n"
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
    assert "cut off" in capsys.readouterr().err
    assert call(["replay", str(tmp_path), "--why", "4.5"]) == 0
    assert "4.5" in capsys.readouterr().out
