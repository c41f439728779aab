"""A mission in one process drives the simulated robot of another: `rocs-bt sim` and `rocs-bt drive`."""

import json
import signal
import subprocess
import sys
import time

import pytest

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.drivers.ros2.sim_clock import SimTimeClock
from rocs_bt.errors import InputError
from rocs_bt.simulation.hardware_devices import hardware_clock

PATIENCE = 120.0  # [s]
ROBOT = """
format = "robot/3"
base = "pioneer_p3dx"

[ros2]
use_sim_time = true

[[sensor]]
name = "sonar"
driver = "ros2"
type = "sensor_msgs/msg/Range"
topics = [{topics}]

[[sensor]]
name = "position"
driver = "ros2"
topic = "odom"
type = "nav_msgs/msg/Odometry"

[[sensor]]
name = "orientation"
driver = "ros2"
topic = "odom"
type = "nav_msgs/msg/Odometry"
take = "orientation"

[[sensor]]
name = "encoders"
driver = "ros2"
topic = "joint_states"
type = "sensor_msgs/msg/JointState"
joints = ["left_wheel", "right_wheel"]
wheel_radius = "0.0975 m"

[[actuator]]
name = "wheels"
driver = "ros2"
topic = "cmd_vel"
isolated = true
"""
SCENARIO = """
format = "scenario/2"
base = "exp1"
doc = "EXP1 with the robot in a simulator."

[[agent]]
name = "R2"
robot = "simulated_p3dx"
"""
ALONE = """
format = "scenario/2"
doc = "EXP1 without R1, whose course depends on when the mission begins."
world = "arena_box"
duration = "60 s"
[[place]]
name = "goal"
kind = "goal"
x = "0 m"
y = "0 m"
tolerance = "0.1 m"
[[agent]]
name = "R2"
robot = "pioneer_p3dx"
mission = "go_to"
rules = ["avoid_collision"]
x = "-1.0 m"
y = "2.0 m"
yaw = "-63 deg"
success = { goal = "goal" }
parameters = { goal = "goal", cruise = "0.5 m/s" }
"""


@pytest.fixture
def project(tmp_path):
    for folder in ("planners", "rules", "robots/simulated_p3dx", "scenarios"):
        (tmp_path / folder).mkdir(parents=True)
    topics = ", ".join(f'"range/sonar{i}"' for i in range(16))
    (tmp_path / "robots/simulated_p3dx/robot.toml").write_text(ROBOT.format(topics=topics))
    (tmp_path / "scenarios/alone.toml").write_text(ALONE)
    (tmp_path / "scenarios/exp1_ros2.toml").write_text(SCENARIO)
    return tmp_path


class Drive:
    """`rocs-bt drive` as a process."""

    def __init__(self, project, environment, *options):
        command = [sys.executable, "-m", "rocs_bt.cli", "drive", "exp1_ros2", "--out", "run", "--no-report", *options]
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


def test_exp1_over_the_simulator_is_that_in_process_even_with_a_pause(simulator, project, ros_environment):
    process = simulator("alone", "--rate", "2")
    drive = Drive(project, ros_environment)
    drive.wait_for_start()
    time.sleep(1.0)
    process.process.send_signal(signal.SIGSTOP)
    time.sleep(1.5)
    process.process.send_signal(signal.SIGCONT)
    code, over_ros, text = drive.end()
    assert (code, over_ros["outcome"]) == (0, "success"), text
    assert over_ros["collisions"] is None
    process.end()
    assert "collision" not in process.errors
    assert commands_of(process) > 100
    in_process = rocs_bt.run("alone", Catalog.here(project)).summary.agents["R2"]
    assert over_ros["time_to_goal"] == pytest.approx(in_process.time_to_goal, rel=0.25)
    assert over_ros["path_length"] == pytest.approx(in_process.path_length, rel=0.25)
    assert over_ros["rules"] == list(in_process.rules)


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
