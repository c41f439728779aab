"""`rocs-bt drive` in a process of its own: however it ends, the last datagrams to the robot are neutral."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rocs_bt.cli.main import call
from rocs_bt.event import MotionHeld, MotionReleased, OutcomeDecided, RuleChanged
from rocs_bt.record import Recording

from ..pages import log_of
from ..udp_robot import UdpRobot
from .conftest import DRIVE, REPORTED, driving

NEUTRAL = [0.0, 0.0]
BUTTON = '''

class Encoders(UdpSensor):
    """Encoders of a controller that also sends its emergency stop button, and a second button for go."""

    def __init__(self, name, host):
        super().__init__(name, host)
        self._host = host

    def read(self):
        if self._link.newest("stop").values[0]:
            self._host.emergency_stop("the button")
        else:
            self._host.emergency_released()
        if self._link.newest("go").values[0]:
            self._host.go("the second button")
        return super().read()
'''


def ends_in_neutral(robot: UdpRobot) -> bool:
    """Whether the robot moved, and its last three datagrams are neutral."""
    return robot.moved and robot.commands[-3:] == [NEUTRAL] * 3


def isolated(*quick: bool) -> pytest.MarkDecorator:
    """Parameter `isolated`: whether the actuators have a process of their own; what is not named is for `make soak`."""
    marks = {value: () if value in quick else pytest.mark.soak for value in (False, True)}
    names = {False: "own_process", True: "isolated"}
    return pytest.mark.parametrize("isolated", [pytest.param(v, marks=marks[v], id=names[v]) for v in marks])


@isolated(False, True)
def test_sigterm(creep, robot, isolated):
    assert_ended_by(signal.SIGTERM, creep, robot, isolated)


@isolated(True)
@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGHUP, marks=pytest.mark.soak)])
def test_another_signal(creep, robot, isolated, number):
    assert_ended_by(number, creep, robot, isolated)


def assert_ended_by(number, creep, robot, isolated):
    creep(isolated=isolated)
    with driving(command=REPORTED if isolated else DRIVE) as process:
        robot.wait_until_moving()
        process.send_signal(number)
        code, out, err = process.end()
    assert code == 128 + number
    assert ends_in_neutral(robot)
    assert out.startswith(f"R2 interrupted (real, seed 1): {number.name} ended the run\n")
    assert f"{number.name}: ending the run" in err
    assert Path("runs/real-1/report.html").exists() == isolated


@pytest.mark.parametrize("number", [pytest.param(signal.SIGINT, marks=pytest.mark.soak), signal.SIGTERM])
def test_a_signal_before_the_start_moves_nothing_and_writes_the_files(creep, robot, number):
    creep(isolated=True)
    robot.silent = {"sonar"}
    with driving("--wait", "60") as process:
        assert process.stderr.readline().startswith("waiting for R2/sonar: no sample: the robot has not sent 'sonar'")
        process.send_signal(number)
        code, out, _ = process.end()
    assert (code, robot.moved) == (128 + number, False)
    assert out.startswith(f"R2 interrupted (real, seed 1): {number.name} ended the run\n")
    assert json.loads(Path("runs/real-1/summary.json").read_text())["agents"]["R2"]["path_length"] == 0.0


@isolated(True)
def test_the_time_is_over(creep, robot, isolated):
    creep(isolated=isolated)
    with driving("--for", "1") as process:
        code, out, _ = process.end()
    assert (code, ends_in_neutral(robot)) == (1, True)
    assert out.startswith("R2 timeout")


@isolated(False)
def test_a_leaf_raises_until_the_mission_fails(creep, robot, isolated):
    creep(isolated=isolated, raises=True)
    with driving() as process:
        code, out, _ = process.end()
    assert (code, ends_in_neutral(robot)) == (1, True)
    assert out.startswith("R2 failed (real, seed 1): the mission failed: leaf 'both/worm' raised ValueError: a worm")


@isolated(True)
def test_a_sensor_falls_silent(creep, robot, isolated):
    creep(isolated=isolated)
    with driving("--for", "30") as process:
        robot.wait_until_moving()
        robot.silent = {"sonar"}
        robot.wait_until_neutral()
        process.send_signal(signal.SIGTERM)
        code, out, _ = process.end()
    assert (code, ends_in_neutral(robot)) == (128 + signal.SIGTERM, True)
    fired = [e.rule for e in Recording.open(Path("runs/real-1")).events() if isinstance(e, RuleChanged)]
    assert "avoid_collision/Blind" in fired
    assert "the sensor" in out or "sensor sonar" in out


@isolated(False, True)
def test_the_actuators_driver_raises(creep, robot, isolated):
    worm = '    def command(self, values):\n        """Send wheel speeds [m/s]; a lost network must not block."""\n'
    count = '        self.count = getattr(self, "count", 0) + 1\n        if self.count == 15 and any(values):\n'
    raises = f'{worm}{count}            raise RuntimeError("the fuse blew")\n'
    creep(isolated=isolated, driver=lambda text: text.replace(worm, raises))
    with driving() as process:
        code, out, _ = process.end()
    assert (code, ends_in_neutral(robot)) == (1, True)
    assert "R2 error (real, seed 1): actuator 'R2/wheels' raised: RuntimeError: the fuse blew (udp.py:" in out


SINK = """
import sys
from rocs_bt import drive
from rocs_bt.event import ActuatorCommanded

class Breaks:
    count = 0

    def emit(self, event):
        self.count += isinstance(event, ActuatorCommanded)
        if self.count > 10:
            raise RuntimeError("a worm in the caller")

drive("real", sinks=[Breaks()], out="out", report=False)
"""


@isolated(True)
def test_the_callers_program_raises(creep, robot, isolated):
    creep(isolated=isolated)
    with driving(command=("-c", SINK)) as process:
        code, _, err = process.end()
    assert (code, ends_in_neutral(robot)) == (1, True)
    assert "RuntimeError: a worm in the caller" in err
    (judged,) = [e for e in Recording.open(Path("out")).events() if isinstance(e, OutcomeDecided)]
    assert judged.outcome == "error"


@isolated(True)
def test_two_signals_at_once(creep, robot, isolated):
    creep(isolated=isolated)
    with driving() as process:
        robot.wait_until_moving()
        process.send_signal(signal.SIGTERM)
        process.send_signal(signal.SIGINT)
        code, *_ = process.end()
    assert code in (128 + signal.SIGTERM, 128 + signal.SIGINT)
    assert robot.moved
    assert robot.commands[-1] == NEUTRAL


def test_an_emergency_stop_holds_until_it_is_released_and_somebody_says_go(creep, robot):
    project = creep(isolated=True, driver=lambda text: text + BUTTON)
    toml = project / "robots/udp_p3dx/robot.toml"
    head, _, tail = toml.read_text().partition('name = "encoders"\n')
    toml.write_text(f'{head}name = "encoders"\n{tail.replace("UdpSensor", "Encoders", 1)}')
    robot.extra = {"stop": [0], "go": [0]}
    arguments = [sys.executable, *REPORTED]
    with subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        try:
            robot.wait_until_moving()
            process.stdin.write(b"\n")  # nobody asked yet
            process.stdin.flush()
            robot.extra = {"stop": [1], "go": [1]}
            robot.wait_until_neutral()
            robot.extra = {"stop": [0], "go": [0]}
            line = b""
            while b"released" not in line:
                line = process.stderr.readline()
            assert line.endswith(b"R2 held: emergency stop released, waiting for go; press Enter to go\n")
            assert robot.commands[-3:] == [NEUTRAL] * 3
            process.stdin.write(b"\n")
            process.stdin.flush()
            robot.wait_until_moving()
            robot.extra = {"stop": [1], "go": [0]}
            robot.wait_until_neutral()
            robot.extra = {"stop": [0], "go": [1]}
            robot.wait_until_moving()
            process.send_signal(signal.SIGTERM)
            _, err = process.communicate(timeout=60.0)
            assert process.returncode == 128 + signal.SIGTERM
        finally:
            process.kill()
    assert ends_in_neutral(robot)
    events = [e for e in Recording.open(Path("runs/real-1")).events() if isinstance(e, (MotionHeld, MotionReleased))]
    told = [e.reason if isinstance(e, MotionHeld) else e.by for e in events]
    held = ["emergency stop: the button", "emergency stop released, waiting for go"]
    assert told == [*held, "the terminal", *held, "the second button"]
    assert b"R2 goes on\n" in err
    log = log_of(Path("runs/real-1/report.html"))
    assert "wheels held in neutral: emergency stop: the button" in log
    assert "wheels released by the terminal" in log


def test_with_confirm_nothing_moves_before_enter(creep, robot):
    creep(isolated=True)
    arguments = [sys.executable, *DRIVE, "--confirm", "--for", "1"]
    with subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        try:
            process.stdin.write(b"\n")  # before the sensors are fresh: it does not count
            process.stdin.flush()
            line = b""
            while b"go" not in line:
                line = process.stderr.readline()
            assert line == b"waiting for go; press Enter to go\n"
            assert not robot.moved
            out, _ = process.communicate(b"\n", timeout=60.0)
        finally:
            process.kill()
    assert ends_in_neutral(robot)
    assert process.returncode == 1
    assert out.startswith(b"R2 timeout (real, seed 1)")


def test_the_recording_of_a_run_on_hardware_serves_all_commands(creep, robot, capsys):
    creep(isolated=True)
    with driving("--for", "2") as process:
        assert process.end()[0] == 1
    capsys.readouterr()
    start = Recording.open(Path("runs/real-1")).header.start
    summary = json.loads(Path("runs/real-1/summary.json").read_text())
    assert call(["report", "runs/real-1"]) == 0
    assert json.loads(Path("runs/real-1/summary.json").read_text()) == summary
    assert call(["replay", "runs/real-1", "--why", str(start + 1.0)]) == 0
    assert call(["plot", "runs/real-1", "--out", "figures"]) == 0
    assert list(Path("figures").iterdir())
    rules = Path("rules/stricter.toml")
    rules.parent.mkdir()
    rules.write_text('format = "rules/1"\ninclude = ["avoid_collision"]\n')
    capsys.readouterr()
    assert call(["rules", "replay", "avoid_collision", "runs/real-1"]) == 0
    out = capsys.readouterr().out
    assert "collision" not in out.replace("avoid_collision", "")
    assert call(["replay", "runs/real-1"]) == 2
    assert "threaded mode" in capsys.readouterr().err
