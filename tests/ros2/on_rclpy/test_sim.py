"""`rocs-bt sim --ros2` is a robot for plain ROS 2: a node with use_sim_time observes and drives it."""

from __future__ import annotations

import math
import time

import pytest
import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, Range

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
            ("/clock", Clock, 1),
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
    driver.until(lambda: len(driver.newest) == 4 and driver.now() > 0.0)
    took, end = math.inf, time.monotonic() + PATIENCE
    while not 0.4 < took < 0.8:  # twice real time; a loaded machine is late, and catches up
        assert time.monotonic() < end, f"a simulated second takes {took:.2f} s"
        wall, simulated = time.monotonic(), driver.now()
        driver.until(lambda until=simulated + 1.0: driver.now() > until)
        took = time.monotonic() - wall
    odom = driver.newest["odom"]
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
    assert "stopped 1 time without one" in process.text
