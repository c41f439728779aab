"""EXP1 on the robot in plain rclpy, by rclpy."""

from __future__ import annotations

import pytest

from ..exp1 import campaign, episode

pytestmark = pytest.mark.usefixtures("awake")


def test_the_mission_drives_the_robot_to_the_goal(counterpart, tmp_path):
    ended = episode(counterpart, tmp_path, "rclpy")
    assert ended["clean"], ended


@pytest.mark.soak
def test_twenty_runs(counterpart, tmp_path):
    campaign(counterpart, tmp_path, "rclpy")
