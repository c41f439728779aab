"""rclpy, and rclpy with DDS without ROS, in both directions."""

from __future__ import annotations

import pytest

from rocs_bt.ros2.network.connect import open_transport
from rocs_bt.ros2.settings import Ros2Settings

from ..transport_contract import DISTRO, TransportContract


class TestRclpy(TransportContract):
    sends = receives = "rclpy"


class TestRclpyToDds(TransportContract):
    sends, receives = "rclpy", "dds"


class TestDdsToRclpy(TransportContract):
    sends, receives = "dds", "rclpy"

    @pytest.fixture(autouse=True)
    def _named(self, request):
        if DISTRO == "kilted" and ("endpoints" in request.node.name or "namespace" in request.node.name):
            pytest.skip("Kilted knows the node of DDS without rmw, but does not assign its endpoints to it")


def test_auto_is_rclpy_where_it_can_be_imported(ros_environment):
    transport = open_transport(Ros2Settings())
    assert transport.name == "rclpy"
    transport.close()
