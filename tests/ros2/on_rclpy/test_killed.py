"""Agents by rclpy that are killed or stopped: the robot is commanded zero in time."""

from __future__ import annotations

import pytest

from ..killed import BRAKING, OWN_TIMEOUT, SOON, both_killed, driven, killed, paused

LIMITS = {killed: SOON, paused: SOON, both_killed: OWN_TIMEOUT + BRAKING}


@pytest.mark.parametrize("fault", LIMITS)
def test_the_robot_stops_in_time(counterpart, tmp_path, request, fault):
    with driven(counterpart, tmp_path, "rclpy", request.config.getoption("--real-time")) as robot:
        robot.drive(0.5)
        _, awake = fault(robot)
        assert awake <= LIMITS[fault]
