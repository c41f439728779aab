"""SIGINT, SIGTERM and SIGHUP end `rocs-bt run` in order; a second one ends it at once."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import signal
import subprocess
import sys
import termios
from pathlib import Path

import pytest

from rocs_bt.cli.main import call
from rocs_bt.event import ActuatorCommanded, AgentStopped, Event, OutcomeDecided
from rocs_bt.record import Recording

from .conftest import BEGUN, Process

RUN = ("-m", "rocs_bt", "run")
SLEEPS = """
import time

import py_trees
from rocs_bt.base.units import MetresPerSecond


class Sleeps(py_trees.behaviour.Behaviour):
    ticks = 0

    def update(self):
        self.ticks += 1
        if self.ticks > 40:
            open("asleep", "x").write("zzz")
            time.sleep(300.0)
        return py_trees.common.Status.RUNNING


def build(mission, *, first: str = "", second: str = "", cruise: MetresPerSecond = 0.4):
    drive = py_trees.composites.Parallel("drive", py_trees.common.ParallelPolicy.SuccessOnAll())
    drive.add_children([mission.act("GoTo", goal="gate", cruise=cruise), Sleeps("sleeps")])
    return drive
"""


def summary_in(folder: Path) -> dict:
    return json.loads((folder / "summary.json").read_text())


def last_commands(events: list[Event]) -> list[list[float]]:
    """The last command to each agent's wheels."""
    found = {e.agent: e.values for e in events if isinstance(e, ActuatorCommanded) and e.actuator == "wheels"}
    return list(found.values())


@pytest.mark.parametrize(
    ("received", "mode"),
    [
        (signal.SIGINT, "lockstep"),
        (signal.SIGHUP, "lockstep"),
        (signal.SIGTERM, "threaded"),
    ],
)
def test_a_signal_ends_the_run_in_order(project, start, received, mode):
    process: Process = start(*RUN, "long", "--mode", mode, "--out", "out")
    process.wait_for(project / "out/run.mcap")
    process.send_signal(received)
    assert (
        process.notice()
        == f"{received.name}: ending the run and writing its report; a second signal ends it at once.\n"
    )
    code, out, err = process.end()
    assert (code, err) == (128 + received, "")
    reason = f"{received.name} ended the run"
    assert out.startswith(f"R2 interrupted (long, seed 1): {reason}\n")
    assert "Report: out/report.html" in out
    recording = Recording.open(project / "out")
    events = list(recording.events())
    assert recording.complete
    assert json.loads(recording.summary.to_json()) == summary_in(project / "out")
    assert [(e.outcome, e.reason) for e in events if isinstance(e, OutcomeDecided)] == [("interrupted", reason)]
    assert [e.by for e in events if isinstance(e, AgentStopped)] == [reason]
    assert last_commands(events) == [[0.0, 0.0]]
    assert (project / "out/report.html").read_text().rstrip().endswith("</html>")
    if mode == "lockstep":
        assert call(["replay", "out"]) == 0


def test_a_second_signal_ends_at_once_and_in_neutral(project, start, capsys):
    (project / "planners/missions/patrol.py").write_text(SLEEPS)
    process: Process = start(*RUN, "first", "--out", "out")
    process.wait_for(project / "asleep", 1)
    process.send_signal(signal.SIGINT)  # the leaf sleeps on: the run cannot end in order
    process.notice()
    process.send_signal(signal.SIGTERM)
    code, out, err = process.end(20.0)
    assert (code, out) == (128 + signal.SIGTERM, "")
    assert "ended at once by SIGTERM\n" in err
    assert "There is no summary.json and no report.html. To create both: rocs-bt report out\n" in err
    events = list(Recording.open(project / "out").events())
    assert [e.outcome for e in events if isinstance(e, OutcomeDecided)] == ["interrupted"]
    assert last_commands(events) == [[0.0, 0.0]]
    capsys.readouterr()
    assert call(["report", "out"]) == 0
    assert "R1 interrupted (first, seed 1): ended at once by SIGTERM" in capsys.readouterr().out
    assert summary_in(project / "out")["agents"]["R1"]["outcome"] == "interrupted"


_WAITING = """
import time
from pathlib import Path

import rocs_bt


class Live:
    def begin(self, header):
        Path("begun").touch()
        while not Path("go").exists():
            time.sleep(0.01)

    def emit(self, event):
        pass

    def take(self):
        return ()


rocs_bt.run("first", out="out", live=Live())
"""


def test_a_signal_before_the_first_control_period_ends_the_run_in_order(project, start):
    process: Process = start("-c", _WAITING)
    process.wait_for(project / "begun", 0)
    process.send_signal(signal.SIGTERM)
    (project / "go").touch()
    assert process.end() == (-signal.SIGTERM, "", "")  # its usual effect, after all files are written
    assert summary_in(project / "out")["agents"]["R1"]["reason"] == "SIGTERM ended the run"
    assert last_commands(list(Recording.open(project / "out").events())) == [[0.0, 0.0]]
    assert (project / "out/report.html").exists()


def test_a_terminal_that_closes_may_send_sighup_twice(project, start):
    process: Process = start(*RUN, "long", "--out", "out")
    process.wait_for(project / "out/run.mcap")
    process.send_signal(signal.SIGHUP)
    process.notice()
    process.send_signal(signal.SIGHUP)
    code, out, _ = process.end()
    assert code == 128 + signal.SIGHUP
    assert out.startswith("R2 interrupted (long, seed 1): SIGHUP ended the run\n")
    assert (project / "out/report.html").exists()


def test_an_ignored_signal_stays_ignored(project, start):
    process: Process = start("-c", _IGNORING)
    process.wait_for(project / "out/run.mcap")
    process.send_signal(signal.SIGHUP)
    process.wait_for(project / "out/run.mcap", 3 * BEGUN)  # it goes on
    process.send_signal(signal.SIGTERM)
    assert process.end()[0] == 128 + signal.SIGTERM
    assert summary_in(project / "out")["agents"]["R2"]["reason"] == "SIGTERM ended the run"


_IGNORING = """
import signal, sys
signal.signal(signal.SIGHUP, signal.SIG_IGN)
from rocs_bt.cli.main import call
sys.exit(call(["run", "long", "--out", "out"]))
"""


def test_a_terminal_that_is_closed_loses_no_file(project):
    """As with an ssh session that breaks off: SIGHUP, and nothing can be printed any more."""
    ours, theirs = pty.openpty()
    with subprocess.Popen(
        [sys.executable, *RUN, "long", "--out", "out"],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
    ) as process:
        try:
            os.close(theirs)
            Process.wait_for(process, project / "out/run.mcap")
            assert os.read(ours, 100)  # the progress bar begins
            os.close(ours)
            assert process.wait(60.0) == 128 + signal.SIGHUP
        finally:
            process.kill()
    assert Recording.open(project / "out").complete
    assert summary_in(project / "out")["agents"]["R2"]["outcome"] == "interrupted"
    assert (project / "out/report.html").read_text().rstrip().endswith("</html>")
