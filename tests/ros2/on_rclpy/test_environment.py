"""Plain ROS 2 beside rocs_bt in one interpreter."""

from __future__ import annotations

import time

import pytest
import rclpy
from rclpy.qos import qos_profile_sensor_data
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import LaserScan

import rocs_bt


@pytest.mark.usefixtures("ros_environment")
def test_raw_messages_are_published_and_taken_without_an_executor():
    """`handle` is internal to rclpy: this test shows when it changes."""
    assert rocs_bt.__version__
    rclpy.init()
    try:
        node = rclpy.create_node("both")
        publisher = node.create_publisher(LaserScan, "scan", qos_profile_sensor_data)
        subscription = node.create_subscription(LaserScan, "scan", lambda _: None, qos_profile_sensor_data)
        sent = LaserScan(ranges=[1.0, 2.0])
        taken, end = None, time.monotonic() + 30.0
        while taken is None and time.monotonic() < end:
            publisher.publish(serialize_message(sent))
            time.sleep(0.01)
            taken = subscription.handle.take_message(LaserScan, True)
        data, info = taken
        assert deserialize_message(data, LaserScan) == sent
        assert abs(1e-9 * info["source_timestamp"] - time.time()) < 1.0
    finally:
        rclpy.shutdown()
