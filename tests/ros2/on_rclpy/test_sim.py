"""`rocs-bt sim --ros2` is a robot for plain ROS 2: a node with use_sim_time observes and drives it."""

from __future__ import annotations

import math
import re
import time
from xml.etree import ElementTree as xml

import pytest
import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, Range
from std_msgs.msg import String

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

PATIENCE = 30.0  # [s]


class Driver:
    """A node with simulated time that drives a robot and keeps the newest messages by topic."""

    def __init__(self, stamped):
        simulated = Parameter("use_sim_time", Parameter.Type.BOOL, True)
        self.node = rclpy.create_node("driver", parameter_overrides=[simulated])
        self.type, self.newest = TwistStamped if stamped else Twist, {}
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.publisher = self.node.create_publisher(self.type, "cmd_vel", 1)
        for name, kind, qos in (
            ("odom", Odometry, 10),  # reliable, as the defaults of many programs
            ("joint_states", JointState, 10),
            ("range/sonar3", Range, qos_profile_sensor_data),
            ("/range/sonar4", Range, 5),
            ("/clock", Clock, 1),
            ("robot_description", String, LATCHED),  # published before this node exists
        ):
            self.node.create_subscription(kind, name, lambda m, name=name: self.newest.update({name: m}), qos)

    def until(self, condition, forward=None):
        end, due = time.monotonic() + PATIENCE, 0.0
        while not condition():
            assert time.monotonic() < end, f"it never came: {sorted(self.newest)}"
            if forward is not None and time.monotonic() > due:
                due = time.monotonic() + 0.05
                message = self.type()
                (message.twist if self.type is TwistStamped else message).linear.x = forward
                self.publisher.publish(message)
            self.executor.spin_once(timeout_sec=0.01)

    def now(self):
        return self.node.get_clock().now().nanoseconds * 1e-9


@pytest.fixture
def ros(ros_environment):
    rclpy.init()
    yield
    rclpy.shutdown()


@pytest.mark.parametrize(("transport", "command"), [("rclpy", "TwistStamped"), ("dds", "Twist")])
def test_a_plain_node_follows_its_clock_and_drives_it(simulator, ros, transport, command):
    process = simulator("exp1", "--transport", transport, "--cmd-vel", command, "--rate", "2")
    assert transport in process.text.splitlines()[0]
    driver = Driver(stamped=command == "TwistStamped")
    driver.until(lambda: len(driver.newest) == 6 and driver.now() > 0.0)
    took, end = math.inf, time.monotonic() + PATIENCE
    while not 0.4 < took < 0.8:  # twice real time; a loaded machine is late, and catches up
        assert time.monotonic() < end, f"a simulated second takes {took:.2f} s"
        wall, simulated = time.monotonic(), driver.now()
        driver.until(lambda until=simulated + 1.0: driver.now() > until)
        took = time.monotonic() - wall
    odom = driver.newest["odom"]
    assert min(odom.pose.covariance[::7]) > 0.0
    assert min(odom.twist.covariance[::7]) > 0.0
    links = [each.get("name") for each in xml.fromstring(driver.newest["robot_description"].data).iter("link")]
    assert {"base_footprint", "base_link", "sonar3"} <= set(links)
    clock = driver.node.get_clock()

    def age():
        return clock.now() - Time.from_msg(driver.newest["odom"].header.stamp, clock.clock_type)

    driver.until(lambda: abs(age().nanoseconds) < 0.3e9)
    begin = odom.pose.pose.position
    driver.until(lambda: driver.newest["odom"].twist.twist.linear.x > 0.25, forward=0.3)
    driver.until(lambda: min(driver.newest["joint_states"].velocity) > 2.0, forward=0.3)  # [rad/s] of the wheels
    driver.until(lambda: abs(driver.newest["odom"].twist.twist.linear.x) < 0.01)
    end = driver.newest["odom"].pose.pose.position
    assert math.hypot(end.x - begin.x, end.y - begin.y) > 0.1
    assert driver.newest["range/sonar3"].header.frame_id == "sonar3"
    driver.node.destroy_node()
    assert process.end() == 143
    assert re.search(r"stopped [1-9]\d* times? without one", process.text)  # late commands on a loaded machine: more


@pytest.mark.parametrize("transport", ["rclpy", "dds"])
def test_a_node_of_another_type_or_quality_of_service_is_told_what_to_do(simulator, ros, transport):
    process = simulator("exp1", "--transport", transport)
    node = rclpy.create_node("teleop")
    node.create_publisher(Twist, "cmd_vel", 1)
    process.until_said("/cmd_vel: the node '/teleop' publishes geometry_msgs/msg/Twist, and the type here is")
    node.create_subscription(Odometry, "odom", lambda message: None, LATCHED)
    process.until_said("requested transient_local). Let it request reliable, volatile.")
    node.destroy_node()
    assert process.end() == 143
