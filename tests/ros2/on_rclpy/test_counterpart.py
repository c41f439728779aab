"""The robot in plain rclpy behaves as a robot does: commanded and observed by a plain rclpy client."""

from __future__ import annotations

import math
import time
from pathlib import Path

import mujoco
import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import BatteryState, LaserScan
from std_msgs.msg import Bool, String

from ..robot_process import late_between

ROOT = Path(__file__).resolve().parents[3]
PATIENCE = 30.0  # [s]


class Client:
    """A node that commands a robot and keeps its newest messages by topic."""

    def __init__(self, namespace="", stamped=False, scan=LaserScan):
        self.node = rclpy.create_node("client", namespace=namespace)
        self.type, self.newest = TwistStamped if stamped else Twist, {}
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.publisher = self.node.create_publisher(self.type, "cmd_vel", 1)
        for name, kind in (("scan", scan), ("odom", Odometry), ("battery_state", BatteryState)):
            self.node.create_subscription(
                kind, name, lambda m, name=name: self.newest.update({name: m}), qos_profile_sensor_data
            )

    def command(self, v, w):
        message = self.type()
        twist = message.twist if self.type is TwistStamped else message
        twist.linear.x, twist.angular.z = v, w
        self.publisher.publish(message)

    def until(self, condition, v=None, w=0.0):
        """Look until a condition of the newest messages holds; command (v, w) meanwhile."""
        end = time.monotonic() + PATIENCE
        while not condition(self.newest):
            assert time.monotonic() < end, f"it never came: {sorted(self.newest)}"
            if v is not None:
                self.command(v, w)
            self.executor.spin_once(timeout_sec=0.02)
        return self.newest

    def pose(self):
        self.newest.pop("odom", None)
        pose = self.until(lambda newest: "odom" in newest)["odom"].pose.pose
        return pose.position.x, pose.position.y, 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)


@pytest.fixture
def client(ros_environment):
    assert ros_environment
    rclpy.init()
    yield Client
    rclpy.shutdown()


@pytest.mark.parametrize(("stamped", "namespace"), [(False, ""), (True, "r1")])
def test_it_drives_while_commanded_and_stops_by_its_own_timeout(counterpart, client, stamped, namespace):
    robot = counterpart(*(["--stamped"] if stamped else []), "--namespace", namespace)
    client = client(namespace, stamped)
    client.until(lambda newest: len(newest) == 3)
    assert client.newest["battery_state"].percentage == pytest.approx(0.9, abs=0.01)
    x, y, yaw = client.pose()
    assert (x, y, yaw) == pytest.approx((-1.0, 2.0, math.radians(-63.0)))
    client.until(lambda newest: newest["odom"].twist.twist.linear.x > 0.29, v=0.3)
    client.until(lambda newest: newest["odom"].twist.twist.linear.x == 0.0)
    lines = robot.follow(lambda lines: lines[-1].what == "stopped")
    *_, last = [line for line in lines if line.what == "command"]
    took = lines[-1].t - last.t - late_between(lines, last.t, lines[-1].t)
    assert 0.3 <= took < 0.3 + 0.3 / 3.0 + 0.1  # its time-out, its braking; slack
    ended = robot.end()
    assert ended["expired"] == 1
    assert ended["commands"] == sum(line.what == "command" for line in lines)
    assert not ended["collided"]
    ahead, aside = ended["pose"][0] - x, ended["pose"][1] - y
    assert math.atan2(aside, ahead) == pytest.approx(yaw)


def test_scans_are_the_rays_of_the_arena_of_exp1(counterpart, client):
    """MuJoCo casts the same rays in the world file of EXP1."""
    counterpart("--beams", "720", "--max-range", "2.5", "--pose", "-1.2", "0.4", "0.7")
    client = client()
    scan = client.until(lambda newest: "scan" in newest)["scan"]
    model = mujoco.MjModel.from_xml_path(str(ROOT / "scenarios" / "worlds" / "arena_box.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    expected = []
    for beam in range(720):
        angle = 0.7 + scan.angle_min + beam * scan.angle_increment
        direction, origin = np.array([math.cos(angle), math.sin(angle), 0.0]), np.array([-1.2, 0.4, 0.2])
        found = mujoco.mj_ray(model, data, origin, direction, None, 1, -1, np.zeros(1, dtype=np.int32))
        expected.append(found if 0.0 <= found <= 2.5 else math.inf)
    assert math.inf in expected
    np.testing.assert_allclose(scan.ranges, expected, rtol=1e-4)


def test_it_collides_with_the_box_and_stays_there(counterpart, client):
    robot = counterpart("--pose", "-1.2", "1.0", "0.0")
    client = client()
    client.until(lambda newest: "odom" in newest)
    client.until(lambda newest: newest["odom"].pose.pose.position.x > -0.95, v=0.6)
    end = time.monotonic() + 0.3
    client.until(lambda _: time.monotonic() > end, v=0.6)
    ended = robot.end()
    assert ended["collided"]
    assert ended["min_clearance"] == 0.0
    assert ended["pose"][0] == pytest.approx(-0.75 - 0.183, abs=0.01)  # the west face of the box; the nose


def test_another_robot_on_its_course_is_seen_and_waits(counterpart, client):
    robot = counterpart("--pose", "-1.0", "-1.0", "0.0", "--peer", "1,-1,-2,-1,1.0", "--beams", "360")
    client = client()
    nearest = client.until(lambda newest: "scan" in newest and newest["scan"].ranges[180] < 0.46)["scan"].ranges[180]
    assert nearest > 0.43
    assert robot.end()["min_clearance"] == pytest.approx(0.7 - 0.25 - 0.183, abs=0.02)


def test_an_emergency_stop_is_latched_and_stops_it(counterpart, client):
    robot, client, stops = counterpart(), client(), []
    latched = rclpy.qos.QoSProfile(depth=1, durability=rclpy.qos.DurabilityPolicy.TRANSIENT_LOCAL)
    client.node.create_subscription(Bool, "emergency_stop", lambda message: stops.append(message.data), latched)
    client.until(lambda _: stops == [False])
    client.until(lambda newest: "odom" in newest and newest["odom"].twist.twist.linear.x > 0.1, v=0.2)
    robot.tell("emergency_stop")
    client.until(lambda newest: stops == [False, True] and newest["odom"].twist.twist.linear.x == 0.0, v=0.2)
    robot.tell("released")
    client.until(lambda newest: stops == [False, True, False] and newest["odom"].twist.twist.linear.x > 0.1, v=0.2)


FAULTS = {
    "scan_nan": lambda newest: np.isnan(newest["scan"].ranges).all(),
    "scan_some_nan": lambda newest: np.isnan(newest["scan"].ranges).sum() == 36,
    "scan_short": lambda newest: len(newest["scan"].ranges) == 180,
    "scan_empty": lambda newest: len(newest["scan"].ranges) == 0,
    "odom_nan": lambda newest: math.isnan(newest["odom"].pose.pose.position.x),
    "stamps_zero": lambda newest: newest["scan"].header.stamp.sec == 0,
    "stamps_future": lambda newest: newest["odom"].header.stamp.sec > time.time() + 1e7,
    "stamps_past": lambda newest: newest["scan"].header.stamp.sec < time.time() - 500,
}


def test_faults_happen_when_told(counterpart, client):
    robot, client = counterpart(), client()
    client.until(lambda newest: len(newest) == 3)
    for fault, shows in FAULTS.items():
        client.until(lambda newest, shows=shows: not shows(newest))
        robot.tell(fault)
        client.until(shows)
        robot.tell("fine")


def test_a_scan_stops_some_time_after_the_first_motion(counterpart, client):
    robot, client = counterpart("--fault", "scan_stops", "--after", "0.5"), client()
    client.until(lambda newest: len(newest) == 3)
    begun = time.monotonic()
    client.until(lambda _: "scan_stops" in robot.report()["faults"], v=0.1)
    assert time.monotonic() - begun >= 0.5
    client.newest.pop("scan")
    end = time.monotonic() + 0.2
    client.until(lambda _: time.monotonic() > end)
    client.newest.pop("scan", None)  # one was on its way
    end = time.monotonic() + 0.2
    assert "scan" not in client.until(lambda _: time.monotonic() > end)


def test_a_topic_of_another_type(counterpart, client):
    counterpart("--fault", "scan_string")
    assert client(scan=String).until(lambda newest: "scan" in newest)["scan"].data == "no scan"
