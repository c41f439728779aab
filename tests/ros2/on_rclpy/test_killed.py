"""Agents by rclpy that die: the robot gets zero in time."""

from __future__ import annotations

import pytest

from ...deaths import DEATHS
from ..killed import QUICK, stops_in_time, ten_deaths_of_drives


@pytest.mark.parametrize("death", [*QUICK, "both killed"])
def test_the_robot_stops_in_time(counterpart, tmp_path, request, death):
    stops_in_time(counterpart, tmp_path, "rclpy", request.config.getoption("--real-time"), death)


@pytest.mark.soak
@pytest.mark.parametrize("death", DEATHS)
def test_ten_deaths(counterpart, tmp_path, death):
    ten_deaths_of_drives(counterpart, tmp_path, "rclpy", death)
