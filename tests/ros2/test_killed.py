"""Agents over DDS without ROS that die: the robot in plain rclpy gets zero in time."""

from __future__ import annotations

from contextlib import closing

import pytest

from rocs_bt.ros2.network.connect import open_transport
from rocs_bt.ros2.settings import Ros2Settings

from ..deaths import DEATHS
from .killed import QUICK, driven, is_held_and_goes_on, stops_in_time, ten_deaths_of_drives
from .transport_contract import until


@pytest.mark.parametrize("death", [*QUICK, "both killed"])
def test_the_robot_stops_in_time(counterpart, tmp_path, request, death):
    stops_in_time(counterpart, tmp_path, "dds", request.config.getoption("--real-time"), death)


def test_each_process_has_a_node_name_of_its_own(counterpart, tmp_path):
    both = {"/r1/rocs_bt", "/r1/rocs_bt_wheels"}
    with (
        closing(open_transport(Ros2Settings(transport="dds"), "observer")) as observer,
        driven(counterpart, tmp_path, "dds"),
    ):
        until(lambda: both <= {endpoint.node for endpoint in observer.endpoints()})


def test_a_publisher_that_is_stopped_for_a_while_holds_the_robot_only(counterpart, tmp_path):
    is_held_and_goes_on(counterpart, tmp_path, "dds")


@pytest.mark.soak
@pytest.mark.parametrize("death", DEATHS)
def test_ten_deaths(counterpart, tmp_path, death):
    ten_deaths_of_drives(counterpart, tmp_path, "dds", death)
