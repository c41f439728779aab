"""A robot with isolated wheels: neutral in time whatever becomes of the main process, and their failures reported.

Every time is the wheels' own. In `make test` the time in which their process got no processor does not count; `make
soak` takes the times as they are.
"""

from __future__ import annotations

import os
import signal
import time
from functools import partial
from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content
from rocs_bt.declare import replaced
from rocs_bt.record import Recording
from rocs_bt.record.explanation.why import explain

from ..isolated import HOLD, MAX_AGE, Robot, driven
from ..pages import log_of

SOON = MAX_AGE + 0.05  # [s] from the last command to neutral
END = ["neutral", "neutral", "neutral", "closed"]


@pytest.fixture
def robots(request):
    return partial(driven, real_time=request.config.getoption("--real-time"))


def held(robot: Robot) -> tuple[float, float]:
    """The leaf holds the interpreter: the wheels are neutral before it lets go, and then drive on."""
    held = robot.wheels.until(lambda line: line.what == "held")
    freed = robot.wheels.until(lambda line: line.what == "freed")
    assert freed.t - held.t >= HOLD
    # As soon as the interpreter is free another thread may command, before the leaf tells that it let go.
    meanwhile = [line for line in robot.wheels.lines if line.t < held.t + HOLD]
    *_, newest = [line for line in meanwhile if line.what in ("command", "neutral")]
    assert newest.what == "neutral"
    robot.wheels.until(lambda line: line.moves)
    return robot.wheels.measure(newest)


def stopped(robot: Robot) -> tuple[float, float]:
    """SIGSTOP, as by Ctrl-Z or a debugger; after SIGCONT the robot drives on."""
    robot.wheels.drive()
    robot.main.send_signal(signal.SIGSTOP)
    took = robot.wheels.stop()
    robot.main.send_signal(signal.SIGCONT)
    robot.wheels.until(lambda line: line.moves)
    return took


def killed(robot: Robot) -> tuple[float, float]:
    """Kill -9: the wheels' process goes to neutral, closes the device and ends."""
    robot.wheels.drive()
    robot.main.kill()
    took = robot.wheels.stop()
    robot.wheels.end()
    assert robot.wheels.last == END
    return took


FAULTS = [(held, "1 s"), (stopped, "1000000 s"), (killed, "1000000 s")]


@pytest.mark.parametrize(("fault", "hold"), FAULTS)
def test_the_wheels_are_neutral_in_time(robots, tmp_path, fault, hold):
    with robots(tmp_path, hold=hold) as robot:
        _, awake = fault(robot)
        assert awake <= SOON


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_end_of_the_run_is_neutral(robots, tmp_path, number):
    with robots(tmp_path) as robot:
        robot.wheels.drive()
        robot.main.send_signal(number)
        robot.wheels.end()
        assert robot.wheels.last == END


def test_the_death_of_the_wheels_process_ends_the_run(robots, tmp_path):
    with robots(tmp_path) as robot, robot.wheels.kept_open():
        robot.wheels.drive()
        at = time.monotonic()
        os.kill(robot.wheels.process, signal.SIGKILL)
        for _ in range(3):
            robot.wheels.until(lambda line: line.what == "neutral")
        failed, end = robot.told()
    assert failed[1] == "BlockFailed"
    assert failed[0] - at < 1.0  # promised is a period, 0.05 s
    assert "actuator 'R2/wheels' ended: its process was ended by SIGKILL" in end[1]


LATE = "the process of actuator wheels is late: the machine is busy, its driver waits, or it was stopped (load "
PATIENT = """
from rocs_bt.devices.isolated import silence
silence.HUNG = 1e9
"""
# For the link all time is time in which the process waits for a processor.
STARVED = f"""
import time
{PATIENT}
silence.waited_for_processor = lambda process: time.monotonic()
"""


@pytest.mark.parametrize(("two_owners", "first"), [(True, PATIENT), (False, STARVED)], ids=["two_owners", "starved"])
def test_a_process_that_is_silent_holds_the_robot_until_it_answers(robots, tmp_path, two_owners, first):
    with robots(tmp_path, two_owners=two_owners, first=first) as robot:
        robot.wheels.drive()
        os.kill(robot.wheels.process, signal.SIGSTOP)
        assert robot.tells("MotionHeld")[-1].startswith(LATE)
        if two_owners:
            robot.wheels.until(lambda line: line.what == "neutral")  # sent by the main process
        os.kill(robot.wheels.process, signal.SIGCONT)
        robot.tells("MotionReleased")
        robot.wheels.until(lambda line: line.what == "neutral")
        robot.wheels.drive()


def test_a_process_that_is_silent_for_long_ends_the_run(robots, tmp_path):
    with robots(tmp_path, two_owners=True, out="out") as robot, robot.wheels.kept_open():
        robot.wheels.drive()
        os.kill(robot.wheels.process, signal.SIGSTOP)
        *_, t, _ = robot.tells("MotionHeld")
        *_, (outcome, reason) = robot.told()
    hung = "hung: its process has not answered for 1 s: the driver hangs, or the process was stopped"
    assert (outcome, reason) == ("error", f"actuator 'R2/wheels' {hung}")
    *before, held, one, other = log_of(tmp_path / "out/report.html")
    assert held.startswith(f"wheels held in neutral: {LATE}")
    assert all(line.startswith(("wheels held", "wheels released")) for line in before)  # on a busy machine
    # Two threads write them at the same moment.
    assert sorted((one, other)) == [f"actuator wheels {hung}", f"outcome: error, {reason}"]
    lines = explain(Recording.open(tmp_path / "out"), t).text().splitlines()
    assert f"although a safety gate holds 'wheels' in neutral ({LATE}" in lines[0]  # this robot never rests
    assert any(line.startswith("own pose     R2 at (") for line in lines)


def test_a_driver_that_raises_ends_the_run_in_neutral(robots, tmp_path):
    with robots(tmp_path, "raises") as robot:
        robot.wheels.drive(20)
        robot.wheels.stop()
        assert not any(line.moves for line in robot.wheels.end())
        assert "actuator 'R2/wheels' raised: RuntimeError: a worm (wheels.py:" in robot.told()[-1][1]


def test_in_simulation_the_key_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / "robots" / "apart").mkdir(parents=True)
    (tmp_path / "robots" / "apart" / "robot.toml").write_text(
        'format = "robot/3"\nbase = "pioneer_p3dx"\n[[actuator]]\nname = "wheels"\nisolated = true\n'
    )
    catalog = Catalog(tmp_path)
    assert catalog.load_robot("apart").actuators[0].isolated
    assert not check_content([tmp_path]).faults
    plain = catalog.load_scenario("exp1")
    apart = replaced(plain, agents=tuple(replaced(agent, robot="apart") for agent in plain.agents))
    found = [run(each, catalog, duration=2.0, report=False, out=tmp_path / "run") for each in (plain, apart)]
    assert found[0].summary.trajectory_hash == found[1].summary.trajectory_hash


@pytest.mark.soak
@pytest.mark.parametrize(("fault", "hold"), FAULTS[:2])
def test_twenty_times_in_one_run(robots, tmp_path, fault, hold):
    with robots(tmp_path, hold=hold) as robot:
        report(fault.__name__, [fault(robot) for _ in range(20)])


def report(what, took):
    raw, awake = zip(*took, strict=True)
    print(f"{what}: neutral after {min(raw):.4f} to {max(raw):.4f} s, awake {max(awake):.4f} s")
    assert max(raw) <= SOON
