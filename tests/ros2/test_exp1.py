"""EXP1 on the robot in plain rclpy, over DDS without ROS."""

from __future__ import annotations

import json
import math

import pytest

from rocs_bt import drive

from .exp1 import GOAL, campaign, episode, start_of

pytestmark = pytest.mark.usefixtures("awake")


def test_the_mission_drives_the_robot_to_the_goal(counterpart, tmp_path):
    ended = episode(counterpart, tmp_path, "dds")
    assert ended["clean"], ended
    agent = json.loads((tmp_path / "out" / "summary.json").read_text())["agents"]["R2"]
    assert agent["outcome"] == "success"
    assert (agent["collisions"], agent["min_clearance"]) == (None, None)  # nobody knows


def test_the_shipped_scenario_drives_the_robot_with_its_sonars(counterpart, tmp_path):
    robot = counterpart("--stamped", "--sonars", *start_of(1), distribution="jazzy")
    agent = drive("exp1_ros2", duration=60.0, out=tmp_path / "out").summary.agents["R2"]
    ended = robot.end()
    assert agent.outcome == "success", agent.reason
    assert agent.reflex_activations > 0  # the box is in its path, and only its sonars know
    assert not ended["collided"]
    assert math.hypot(*ended["pose"][:2]) < GOAL + 0.02


@pytest.mark.soak
def test_twenty_runs(counterpart, tmp_path):
    campaign(counterpart, tmp_path, "dds")
