"""Robots whose sensors read topics of ROS 2, and bags of a drive towards a wall that rocs_bt has not written."""

import math

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore

PIONEER = """
format = "robot/3"
base = "pioneer_p3dx"
[ros2]
{ros2}
[[sensor]]
name = "sonar"
driver = "ros2"
type = "sensor_msgs/msg/Range"
topics = [{beams}]
[[sensor]]
name = "position"
driver = "ros2"
topic = "{pose[0]}"
type = "{pose[1]}"
take = "position"
[[sensor]]
name = "orientation"
driver = "ros2"
topic = "{pose[0]}"
type = "{pose[1]}"
take = "orientation"
[[sensor]]
name = "encoders"
driver = "ros2"
topic = "joint_states"
type = "sensor_msgs/msg/JointState"
joints = ["left_wheel", "right_wheel"]
wheel_radius = "0.0975 m"
[[actuator]]
name = "wheels"
driver = "ros2"
topic = "cmd_vel"
"""
ODOM, TF = ("odom", "nav_msgs/msg/Odometry"), ("/tf", "tf2_msgs/msg/TFMessage")

CART = """
format = "robot/3"
[ros2]
{ros2}
[locomotion]
kind = "differential"
actuator = "wheels"
wheel_separation = "0.4 m"
max_wheel_acceleration = "1 m/s2"
latency = "0.1 s"
deceleration = "1 m/s2"
[body]
length = "0.5 m"
width = "0.4 m"
[[sensor]]
name = "lidar"
driver = "ros2"
topic = "{scan}"
type = "{scan_type}"
rays = 90
span = "270 deg"
mount = {{ x = "0 m" }}
unit = "m"
signal = "scan"
monitor = "scan"
{lidar}
[[sensor]]
name = "position"
driver = "ros2"
topic = "odom"
type = "nav_msgs/msg/Odometry"
take = "position"
unit = "m"
signal = "pose"
monitor = "pose"
[[sensor]]
name = "orientation"
driver = "ros2"
topic = "odom"
type = "nav_msgs/msg/Odometry"
take = "orientation"
unit = "rad"
signal = "pose"
monitor = "pose"
[[sensor]]
name = "twist"
driver = "ros2"
topic = "odom"
type = "nav_msgs/msg/Odometry"
take = "twist"
signal = "speed"
monitor = "twist"
{more}
[[monitor]]
name = "scan"
class = "ScanMonitor"
sensors = ["lidar"]
[monitor.group.front]
sectors = [["-20 deg", "20 deg"]]
[monitor.group.left_gap]
sectors = [["20 deg", "100 deg"]]
[monitor.group.right_gap]
sectors = [["-100 deg", "-20 deg"]]
[monitor.group.rear]
blind = true
[[monitor]]
name = "pose"
class = "PoseMonitor"
sensors = ["position", "orientation"]
[[monitor]]
name = "twist"
class = "MotionMonitor"
sensors = ["twist"]
[[actuator]]
name = "wheels"
driver = "ros2"
topic = "cmd_vel"
range = ["-1 m/s", "1 m/s"]
"""

RULE = """
format = "reflex/1"
[threshold]
near = "0.5 m"
[rule.Wall]
when = "min(front) < near and speed > 0.1 m/s"
until = "min(front) > near + 0.1 m"
trigger = "level"
priority = 50
[rule.Wall.action]
name = "Stop"
"""

WALL, HALF, SPEED, RATE, DURATION = 3.0, 0.25, 0.5, 10.0, 6.0  # wall [m], half the robot's length [m], 10 Hz, 6 s
LATCHES = (WALL - HALF - 0.5) / SPEED
"""Time at which the rule latches [s]."""


def pioneer(project, *, ros2="", pose=ODOM, beams="range/sonar{}"):
    """Write the Pioneer as its export publishes it."""
    topics = ", ".join(f'"{beams.format(i)}"' for i in range(16))
    write(project, "pioneer", PIONEER.format(ros2=ros2, beams=topics, pose=pose))


def cart(project, *, ros2="", scan="scan", scan_type="sensor_msgs/msg/LaserScan", lidar="", more=""):
    """Write a cart with a laser scanner and odometry, and a rule file."""
    write(project, "cart", CART.format(ros2=ros2, scan=scan, scan_type=scan_type, lidar=lidar, more=more))
    (project / "rules").mkdir(exist_ok=True)
    (project / "rules" / "wall.toml").write_text(RULE)


def write(project, name, text):
    folder = project / "robots" / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.toml").write_text(text)


class ForeignBag:
    """Bag of a cart that drives to a wall and stops after 5.4 s: odometry, and scans of 720 beams.

    Args:
        path: Bag to write; a name that ends in `.bag` makes a ROS 1 bag.
        storage: Storage plugin of rosbag2.
        compression: Name of a compression mode of rosbag2.
        distro: Distribution of the types.
        definitions: Message types of the bag's own, by name.
    """

    def __init__(self, path, storage="MCAP", compression="NONE", distro="JAZZY", definitions=None):
        self.ros1 = path.suffix == ".bag"
        self.store = get_typestore(Stores.ROS1_NOETIC if self.ros1 else Stores[f"ROS2_{distro}"])
        if definitions:
            self.store.register(definitions)
        if self.ros1:
            self.writer = rosbag1.Writer(path)
        else:
            self.writer = rosbag2.Writer(path, version=9, storage_plugin=rosbag2.StoragePlugin[storage])
            self.writer.set_compression(rosbag2.CompressionMode[compression], rosbag2.CompressionFormat.ZSTD)
        self.connections = {}
        self.start = 1_770_000_000_000_000_000

    def __enter__(self):
        self.writer.open()
        return self

    def __exit__(self, *error):
        self.writer.close()

    def message(self, kind, **fields):
        """Message in which the header of the frame has the time `t` [s] since the start."""
        return self.store.types[kind](**fields)

    def header(self, t, frame):
        nanoseconds = self.start + round(t * 1e9)
        stamp = self.message("builtin_interfaces/msg/Time", sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
        more = {"seq": 0} if self.ros1 else {}
        return self.message("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **more)

    def add(self, topic, t, message):
        """Write a message at a time since the start [s]."""
        kind = message.__msgtype__
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        serialize = self.store.serialize_ros1 if self.ros1 else self.store.serialize_cdr
        self.writer.write(self.connections[topic], self.start + round(t * 1e9), serialize(message, kind))

    def scan(self, t, x, beams=720):
        angles = np.linspace(-0.75 * np.pi, 0.75 * np.pi, beams)
        with np.errstate(divide="ignore"):
            ranges = np.where(np.cos(angles) > 1e-6, (WALL - x) / np.cos(angles), np.inf)
        ranges[ranges > 10.0] = np.inf
        return self.message(
            "sensor_msgs/msg/LaserScan",
            header=self.header(t, "lidar"),
            angle_min=angles[0],
            angle_max=angles[-1],
            angle_increment=angles[1] - angles[0],
            time_increment=0.0,
            scan_time=1.0 / RATE,
            range_min=0.05,
            range_max=10.0,
            ranges=ranges.astype(np.float32),
            intensities=np.zeros(0, np.float32),
        )

    def odometry(self, t, x, speed):
        make, zero = self.message, np.zeros(36)
        vector = {name: f"geometry_msgs/msg/{name}" for name in ("Vector3", "Point", "Quaternion", "Pose", "Twist")}
        pose = make(
            vector["Pose"],
            position=make(vector["Point"], x=x, y=0.0, z=0.0),
            orientation=make(vector["Quaternion"], x=0.0, y=0.0, z=0.0, w=1.0),
        )
        twist = make(
            vector["Twist"],
            linear=make(vector["Vector3"], x=speed, y=0.0, z=0.0),
            angular=make(vector["Vector3"], x=0.0, y=0.0, z=0.0),
        )
        return make(
            "nav_msgs/msg/Odometry",
            header=self.header(t, "odom"),
            child_frame_id="base_link",
            pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=zero),
            twist=make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=zero),
        )

    def drive(self, scan=None, beams=720):
        """Write the drive; `scan` replaces the message of a scan by another, from its time and the position."""
        for count in range(int(DURATION * RATE) + 1):
            t = count / RATE
            x = min(SPEED * t, SPEED * 5.4)
            self.add("/odom", t, self.odometry(t, x, SPEED if t < 5.4 else 0.0))
            self.add("/scan", t, scan(t, x) if scan else self.scan(t, x, beams))
        return self


def foreign_bag(path, **options):
    """Write the drive as a bag; returns its path."""
    with ForeignBag(path, **options) as bag:
        bag.drive()
    return path


assert math.isclose(LATCHES, 4.5)
