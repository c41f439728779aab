"""EXP1 on the robot in plain rclpy, over DDS without ROS."""

from __future__ import annotations

import json

import pytest

from .exp1 import campaign, episode

pytestmark = pytest.mark.usefixtures("awake")


def test_the_mission_drives_the_robot_to_the_goal(counterpart, tmp_path):
    ended = episode(counterpart, tmp_path, "dds")
    assert ended["clean"], ended
    agent = json.loads((tmp_path / "out" / "summary.json").read_text())["agents"]["R2"]
    assert agent["outcome"] == "success"
    assert (agent["collisions"], agent["min_clearance"]) == (None, None)  # nobody knows


@pytest.mark.soak
def test_twenty_runs(counterpart, tmp_path):
    campaign(counterpart, tmp_path, "dds")
