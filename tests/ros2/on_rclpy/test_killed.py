"""Agents by rclpy that are killed or stopped: the robot is commanded zero in time."""

from __future__ import annotations

import pytest

from ..killed import (
    BRAKING,
    OWN_TIMEOUT,
    SOON,
    both_killed,
    driven,
    killed,
    paused,
    publisher_killed,
    publisher_stopped,
    shortest,
)

LIMITS = {
    killed: SOON,
    paused: SOON,
    publisher_killed: SOON,
    publisher_stopped: SOON,
    both_killed: OWN_TIMEOUT + BRAKING,
}


@pytest.mark.parametrize("fault", LIMITS)
def test_the_robot_stops_in_time(counterpart, tmp_path, request, fault):
    def attempt(number: int) -> float:
        folder, real_time = tmp_path / str(number), request.config.getoption("--real-time")
        with driven(counterpart, folder, "rclpy", real_time) as robot:
            robot.drive(0.5)
            return fault(robot)[1]

    assert shortest(attempt, LIMITS[fault]) <= LIMITS[fault]
