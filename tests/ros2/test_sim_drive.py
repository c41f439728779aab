"""A mission in one process drives the simulated robot of another: `rocs-bt sim` and `rocs-bt drive`."""

import json
import signal
import subprocess
import sys
import time

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog
from rocs_bt.ros2.network.sim_clock import SimTimeClock
from rocs_bt.running.hardware_stage import hardware_clock

PATIENCE = 120.0  # [s]
PAUSE = 1.5  # [s] far longer than a sensor may be silent
ROBOT = """
format = "robot/3"
base = "pioneer_p3dx_ros2"
ros2 = { use_sim_time = true }
"""
SCENARIO = """
format = "scenario/2"
base = "exp1"
doc = "EXP1 with the robot in a simulator."

[[agent]]
name = "R2"
robot = "simulated_p3dx"
"""


@pytest.fixture
def project(tmp_path):
    for folder in ("planners", "rules", "robots/simulated_p3dx", "scenarios"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "robots/simulated_p3dx/robot.toml").write_text(ROBOT)
    (tmp_path / "scenarios/exp1_sim.toml").write_text(SCENARIO)
    return tmp_path


class Drive:
    """`rocs-bt drive` as a process."""

    def __init__(self, project, environment, *options, scenario="exp1_sim"):
        command = [sys.executable, "-m", "rocs_bt", "drive", scenario, "--out", "run", "--no-report", *options]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=project, env=environment, stdout=pipe, stderr=pipe, text=True)
        self.summary = project / "run/summary.json"

    def wait_for_start(self):
        """Wait until the sensors are fresh, and the mission begins."""
        while not self.summary.with_name("run.mcap").exists():
            assert self.process.poll() is None, self.process.communicate()
            time.sleep(0.02)

    def end(self):
        """Wait for the end; returns exit code, R2's summary, and what was printed."""
        out, err = self.process.communicate(timeout=PATIENCE)
        assert self.summary.exists(), err
        return self.process.returncode, json.loads(self.summary.read_text())["agents"]["R2"], out + err


def commands_of(simulator):
    return int(simulator.text.rpartition("R2: ")[2].split()[0])


def test_a_mission_follows_the_simulators_clock_at_twice_real_time_and_through_a_pause(
    simulator, project, ros_environment
):
    process = simulator("exp1", "--rate", "2")
    drive = Drive(project, ros_environment)
    drive.wait_for_start()
    time.sleep(1.0)
    process.process.send_signal(signal.SIGSTOP)
    time.sleep(PAUSE)
    process.process.send_signal(signal.SIGCONT)
    code, agent, text = drive.end()
    assert (code, agent["outcome"]) == (0, "success"), text
    mean_speed = agent["path_length"] / agent["time_to_goal"]
    assert 0.1 < mean_speed < 0.4  # [m/s] 0.26 in process; by the wall clock it would be twice as much
    assert agent["collisions"] is None
    process.end()
    assert "collision" not in process.errors
    assert commands_of(process) > 100


@pytest.mark.soak
def test_the_shipped_scenarios_run_together(simulator, project, ros_environment):
    process = simulator("exp1")
    code, agent, text = Drive(project, ros_environment, scenario="exp1_ros2").end()
    assert (code, agent["outcome"]) == (0, "success"), text
    process.end()
    assert "collision" not in process.errors


@pytest.mark.soak
def test_a_simulator_that_restarts_ends_the_run(simulator, project, ros_environment):
    first = simulator("exp1")
    drive = Drive(project, ros_environment)
    drive.wait_for_start()
    first.end()
    simulator("exp1")
    code, agent, text = drive.end()
    assert (code, agent["outcome"]) == (1, "error"), text
    assert "the simulator was restarted" in text


def test_without_a_simulator_the_run_says_what_to_start(project, ros_environment):
    drive = Drive(project, ros_environment, "--wait", "1")
    out, err = drive.process.communicate(timeout=PATIENCE)
    assert drive.process.returncode != 0
    assert "no message on /clock within 1 s. Start the simulator" in out + err


def test_all_robots_of_a_run_follow_the_same_clock(project):
    catalog = Catalog.here(project)
    robots = [catalog.load_robot(name) for name in ("simulated_p3dx", "pioneer_p3dx")]
    with pytest.raises(InputError, match="use_sim_time must be the same for all robots of a run"):
        hardware_clock(robots, None, 1.0, lambda: "")
    assert not isinstance(hardware_clock(robots[1:], None, 1.0, lambda: ""), SimTimeClock)
