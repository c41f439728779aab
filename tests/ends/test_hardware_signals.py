"""Signals to a process that drives a robot, on hardware or simulated in threads: neutral in time, then all files.

Times are the wheels' own, from the moment at which the signal is sent. In `make test` the time in which their process
got no processor does not count; `make soak` takes the times as they are.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest

from rocs_bt.event import AgentStopped, OutcomeDecided
from rocs_bt.record import Recording

from ..isolated import PATIENCE, WHEELS, Log, Robot, driven
from .conftest import LONG

SOON = 0.35  # [s] from the signal to neutral
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]


def ended(robot: Robot, number: signal.Signals, delay: float = 0.0) -> tuple[float, float]:
    """Send a signal to a robot that drives.

    Returns:
        Time until the wheels were neutral [s], and what of it their process was awake [s].
    """
    robot.wheels.drive()
    time.sleep(delay)
    sent = time.monotonic()
    robot.main.send_signal(number)
    neutral = robot.wheels.until(lambda line: line.what == "neutral")
    gaps = [(line.t - line.values[0] + 0.002, line.t) for line in robot.wheels.lines if line.what == "late"]
    late = sum(max(min(end, neutral.t) - max(begin, sent), 0.0) for begin, end in gaps)
    assert not any(line.moves for line in robot.wheels.end())  # and nothing moves them again
    robot.main.wait(PATIENCE)
    return neutral.t - sent, neutral.t - sent - late


@pytest.mark.parametrize(
    ("number", "isolated"), [(signal.SIGTERM, False), (signal.SIGHUP, False), (signal.SIGINT, True)]
)
def test_a_signal_is_neutral_first_then_all_files(tmp_path, request, number, isolated):
    real_time = request.config.getoption("--real-time")
    with driven(tmp_path, isolated=isolated, out="out", real_time=real_time) as robot:
        _, awake = ended(robot, number)
        assert awake <= SOON
        # Then the signal has its usual effect; Python's own, of SIGINT, is a KeyboardInterrupt.
        assert robot.main.returncode == -number
    reason = f"{number.name} ended the run"
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    agent = summary["agents"]["R2"]
    assert (agent["outcome"], agent["reason"]) == ("interrupted", reason)
    assert [agent[key] for key in ("collisions", "struck", "contacts", "min_clearance")] == [None] * 4
    assert agent["path_length"] > 0.05  # by its own estimate
    assert (summary["simulated"], summary["trajectory_hash"]) == (False, None)
    recording = Recording.open(tmp_path / "out")
    assert recording.complete
    assert json.loads(recording.summary.to_json()) == summary
    found = [e for e in recording.events() if isinstance(e, (AgentStopped, OutcomeDecided))]
    assert [(type(e), e.agent) for e in found] == [(AgentStopped, "R2"), (OutcomeDecided, "R2")]
    page = (tmp_path / "out/report.html").read_text()
    assert "collisions" not in page
    assert page.rstrip().endswith("</html>")


SIMULATED = f"""
import sys
from rocs_bt import run
from rocs_bt.catalog import Catalog
{WHEELS}

class Telling(Wheels):
    def __init__(self, device):
        super().__init__("wheels", None, plan="", log=sys.argv[1])
        self.device = device

    def command(self, values):
        self.tell("command", *values)
        self.device.command(values)

    def neutral(self):
        self.tell("neutral")
        self.device.neutral()


def prepare(stage):
    stage.actuators["R2"]["wheels"].wrap(Telling)


run("long", Catalog.here(), mode="threaded", prepare=prepare, out="out", report=False)
"""


@contextmanager
def simulated(folder: Path) -> Iterator[Robot]:
    """A threaded run in simulation, whose wheels tell what they get."""
    (folder / "scenarios").mkdir()
    (folder / "scenarios/long.toml").write_text(LONG)
    log = Log(folder / "log")
    command = [sys.executable, "-c", SIMULATED, str(folder / "log")]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as main:
        try:
            yield Robot(main, log.begin())
        finally:
            main.kill()
            log.close()


WAYS = {
    "hardware": partial(driven, isolated=False, real_time=True),
    "isolated": partial(driven, real_time=True),
    "simulated": simulated,
}


@pytest.mark.soak
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("number", SIGNALS)
def test_twenty_times(tmp_path, number, way):
    took = []
    for count in range(20):
        folder = tmp_path / str(count)
        folder.mkdir()
        with WAYS[way](folder) as robot:
            took.append(ended(robot, number, delay=count * 0.0025))  # at each part of a control period
    raw = sorted(each for each, _ in took)
    print(f"{way}, {number.name}: neutral after {raw[0]:.4f} to {raw[-1]:.4f} s, median {raw[10]:.4f} s")
    assert raw[-1] <= SOON
