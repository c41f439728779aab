"""Agents by rclpy that die: the robot gets zero in time."""

from __future__ import annotations

import pytest

from ...deaths import DEATHS
from ..killed import QUICK, is_held_and_goes_on, stops_in_time, ten_deaths_of_drives


@pytest.mark.parametrize("death", [*QUICK, "both killed"])
def test_the_robot_stops_in_time(counterpart, tmp_path, request, death):
    stops_in_time(counterpart, tmp_path, "rclpy", request.config.getoption("--real-time"), death)


def test_a_publisher_that_is_stopped_for_a_while_holds_the_robot_only(counterpart, tmp_path):
    is_held_and_goes_on(counterpart, tmp_path, "rclpy")


@pytest.mark.soak
@pytest.mark.parametrize("death", DEATHS)
def test_ten_deaths(counterpart, tmp_path, death):
    ten_deaths_of_drives(counterpart, tmp_path, "rclpy", death)
