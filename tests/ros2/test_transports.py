"""DDS without ROS, between two participants; the pairs with rclpy are in on_rclpy."""

from __future__ import annotations

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.ros2.network.connect import open_transport
from rocs_bt.ros2.settings import Ros2Settings

from .transport_contract import TransportContract


class TestDds(TransportContract):
    sends = receives = "dds"


def test_a_process_has_one_network_for_each_domain(ros_environment):
    transport = open_transport(Ros2Settings(transport="dds"))
    with pytest.raises(InputError, match=r"already uses the ROS domain .* not with network = 'lan'"):
        open_transport(Ros2Settings(transport="dds", network="lan"))
    transport.close()
