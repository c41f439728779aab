"""Export of a run on hardware: the bag has the messages from which the robot's sensors took their values."""

import threading
import time

import msgspec
import numpy as np
import py_trees
import pytest

from rocs_bt import drive
from rocs_bt.base.geometry import Pose3, Twist3
from rocs_bt.catalog import Catalog
from rocs_bt.event import SensorRead
from rocs_bt.record import Recording
from rocs_bt.record.tables import signal_table
from rocs_bt.ros2.devices.parameters import TRANSFORMS, TWIST_STAMPED, Ros2SensorParameters
from rocs_bt.ros2.messages import fields as messages
from rocs_bt.ros2.messages.forms import POSE_TAKES, make_take, pose3
from rocs_bt.ros2.messages.message_types import MessageTypes
from rocs_bt.ros2.network import node
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.network.transport import Endpoint

from ..ros2.network import Network
from .conftest import read
from .robots import cart
from .test_export import by_mcap, frames, seconds

SENSORS = {  # topic, message type, other keys
    "wheel_speeds": ("joint_states", "sensor_msgs/msg/JointState", 'joints = ["l", "r"]\nwheel_radius = "0.1 m"'),
    "wheel_angles": ("joint_states", "sensor_msgs/msg/JointState", 'joints = ["r", "l"]\ntake = "position"'),
    "gyro": ("imu", "sensor_msgs/msg/Imu", ""),
    "tilt": ("imu", "sensor_msgs/msg/Imu", 'take = "attitude"'),
    "heading": ("imu", "sensor_msgs/msg/Imu", 'take = "orientation"'),
    "acceleration": ("imu", "sensor_msgs/msg/Imu", 'take = "acceleration"'),
    "fix": ("fix", "geometry_msgs/msg/PoseWithCovarianceStamped", ""),
    "spread": ("fix", "geometry_msgs/msg/PoseWithCovarianceStamped", 'take = "spread"'),
    "camera": ("/camera", "geometry_msgs/msg/PoseStamped", ""),
    "charge": ("battery", "sensor_msgs/msg/BatteryState", ""),
    "voltage": ("battery", "sensor_msgs/msg/BatteryState", 'take = "voltage"'),
    "health": ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", ""),
    "bumper": ("bumper", "std_msgs/msg/Bool", ""),
    "temperature": ("temperature", "std_msgs/msg/Float64", ""),
    "incline": ("incline", "std_msgs/msg/Float64", 'unit = "deg"'),
    "mode": ("mode", "std_msgs/msg/String", 'words = ["off", "on"]'),
    "beacon": ("/tf", "tf2_msgs/msg/TFMessage", ""),
}
SENSOR = '[[sensor]]\nname = "{}"\ndriver = "ros2"\nmonitor = "all"\nsignal = "read"\n{} = {}\ntype = "{}"\n{}\n'
ALL = """
from rocs_bt import Monitor, Signal


class All(Monitor):
    def signals(self):
        return [Signal("read")]

    def expects(self):
        return {}

    def interpret(self, readings):
        return {"read": [float(len(readings))]}
"""


def messages_at(k):
    """Fields of the k-th message of each topic."""
    t, x = 0.05 * k, 0.01 * k
    header, pose = messages.header(1.0 + t, ""), Pose3(x, 2.0 * x, 0.1, 0.01, 0.02, 0.3)
    twist = Twist3(0.2, 0.0, 0.0, 0.1 + x)
    ranges = 1.0 + x + 0.01 * np.arange(360)
    ranges[17], ranges[200] = np.inf, np.nan
    first, step = -np.pi, np.pi / 180.0
    imu = {**messages.imu(t, "imu", x), "orientation": messages.quaternion(pose), "orientation_covariance": [0.0] * 9}
    imu |= {"linear_acceleration": messages.vector(x, 0.0, 9.8), "linear_acceleration_covariance": [0.0] * 9}
    return {
        "scan": messages.laser_scan(1.0 + t, "laser", ranges, first=first, step=step, limits=(0.1, 8.0)),
        "odom": messages.odometry(1.0 + t, "odom", "base_link", pose, twist),
        "joint_states": messages.joint_state(1.0 + t, ["l", "r"], [x, 2.0 * x], [1.0 + x, 2.0 + x]),
        "imu": {
            **imu,
            "linear_acceleration": messages.vector(x, 0.0, 9.8),
            "linear_acceleration_covariance": [0.0] * 9,
        },
        "fix": messages.pose_with_covariance(1.0 + t, "map", pose, messages.diagonal([(0.1 + x) ** 2] * 6)),
        "/camera": messages.pose_stamped(1.0 + t, "map", pose),
        "battery": {"header": header, "percentage": 0.5, "voltage": 12.0 - x},
        "/diagnostics": {"header": header, "status": [{"name": "motor", "level": k % 3}]},
        "bumper": {"data": k % 20 == 0},
        "temperature": {"data": 20.0 + x},
        "incline": {"data": 5.0 + x},
        "mode": {"data": ("off", "on")[k % 2]},
        "/tf": messages.transforms([messages.transform(1.0 + t, "map", "base_link", pose)]),
        "range/left": messages.sonar_range(1.0 + t, "left", 1.0 + x, opening=0.2, limits=(0.1, 4.0)),
        "range/right": messages.sonar_range(1.0 + t, "right", 5.0 if k % 2 else 2.0, opening=0.2, limits=(0.1, 4.0)),
    }


class Live(Network):
    """Network in memory whose clock runs."""

    def now(self):
        return time.time()


class Robot(threading.Thread):
    """Robot on a network in memory that publishes each topic at 20 Hz."""

    def __init__(self, types):
        super().__init__(daemon=True)
        self.types, self.network, self.over = types, Live(MessageTypes()), threading.Event()
        self.network.peers = [Endpoint("/r1/cmd_vel", TWIST_STAMPED, "/base", False, QoS.COMMAND)]

    def run(self):
        k = 0
        while not self.over.wait(0.05):
            k += 1
            for topic, fields in messages_at(k).items():
                self.network.send(topic if topic.startswith("/") else f"/r1/{topic}", self.types[topic], **fields)


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """Project with the robot `cart` and the scenario `real`."""
    folder = tmp_path_factory.mktemp("hardware")
    more = SENSOR.format("sonar", "topics", ["range/left", "range/right"], "sensor_msgs/msg/Range", "")
    for name, (topic, kind, keys) in SENSORS.items():
        more += SENSOR.format(name, "topic", f"'{topic}'", kind, keys)
    names = ", ".join(f'"{name}"' for name in ("sonar", *SENSORS))
    more += f'[[monitor]]\nname = "all"\nclass = "all.py:All"\nsensors = [{names}]\n'
    cart(folder, ros2='namespace = "r1"', more=more)
    (folder / "robots/cart/all.py").write_text(ALL)
    (folder / "scenarios").mkdir()
    agent = '[[agent]]\nname = "R2"\nrobot = "cart"\n'
    text = f'format = "scenario/2"\nbase = "exp1"\n{agent}rules = ["wall"]\nparameters = {{}}\n'
    (folder / "scenarios/real.toml").write_text(text)
    return folder


@pytest.fixture(scope="module")
def driven(project):
    """Recording of a run on hardware."""
    robot = Catalog(project).load_robot("cart")
    types = {}
    for spec in robot.sensors:
        for topic in spec.parameters.get("topics", [spec.parameters.get("topic")]):
            types[topic] = spec.parameters["type"]
    with pytest.MonkeyPatch.context() as patch:
        thread = Robot(types)
        patch.setattr(node, "open_transport", lambda *_: thread.network)
        thread.start()
        missions = {"R2": lambda mission: py_trees.behaviours.Running("stay")}
        drive("real", Catalog(project), duration=2.0, missions=missions, out=project / "run")
        thread.over.set()
    return Recording.open(project / "run")


def taken(given, message):
    """Values that a sensor takes from a message."""
    if given.type == TRANSFORMS:
        transform = message.transforms[0].transform
        return POSE_TAKES[given.taken](pose3(transform.translation, transform.rotation))
    return make_take(MessageTypes(), given)(message)


def readings(recording, sensor):
    """Readings of a sensor, without those that it has repeated."""
    found = {e.stamp: e for e in recording.events() if isinstance(e, SensorRead) and e.sensor == sensor}
    return list(found.values())


def sent(types, given, topic):
    """Values that a sensor takes from each message that the robot has sent, shape (messages, values)."""
    return np.array([taken(given, types.make(given.type, **messages_at(k)[topic])) for k in range(1, 400)])


@pytest.mark.parametrize("reader", [read, by_mcap], ids=["rosbags", "mcap-ros2-support"])
def test_each_reading_is_in_a_message_of_its_topic(project, driven, export, reader):
    catalog = Catalog(project)
    robot, found = catalog.load_robot("cart"), reader(export(driven, catalog=catalog))
    types, scales = MessageTypes(), {"incline": np.radians(1.0)}
    for spec in robot.sensors:
        given, events = msgspec.convert(spec.parameters, Ros2SensorParameters), readings(driven, spec.name)
        assert len(events) > 5, spec.name
        topics = [found[robot.ros2.topic(name)] for name in given.all_topics]
        originals = [sent(types, given, name) for name in given.all_topics]
        if hasattr(topics[0][0][1], "header"):  # with several sensors: the message with the stamp of the reading
            stamps = np.array([seconds(message.header.stamp) for _, message in topics[0]])
            rows = [int(np.argmin(np.abs(stamps - event.stamp))) for event in events]
            assert max(abs(stamps[row] - event.stamp) for row, event in zip(rows, events, strict=True)) < 0.003
        else:
            rows = range(len(topics[0]))
        for row, event in zip(rows, events, strict=True):
            values = [taken(given, topic[row][1]) for topic in topics]
            for exported, known in zip(values, originals, strict=True):
                assert np.isclose(known, exported, atol=1e-5, equal_nan=True).all(axis=1).any(), spec.name
            scaled = np.concatenate(values) * scales.get(spec.name, 1.0)
            np.testing.assert_allclose(scaled, event.values, atol=1e-6, err_msg=spec.name)


def test_sensors_of_one_topic_have_common_messages(project, driven, export):
    found = read(export(driven, catalog=Catalog(project)))
    for topic in ("/r1/imu", "/r1/battery", "/r1/joint_states"):
        assert len(found[topic]) < 1.6 * len(found["/r1/bumper"]), topic


def test_scan_frames_and_names(project, driven, export):
    """Names are those of the robot, and the agent's estimates do not mix with its measurements."""
    topics = read(export(driven, catalog=Catalog(project)))
    assert {"/r1/cmd_vel", "/r1/signals/front", "/r1/mission"} <= set(topics)
    scan = topics["/r1/scan"][-1][1]
    assert (scan.header.frame_id, len(scan.ranges)) == ("r1/lidar", 90)
    assert scan.angle_min == pytest.approx(np.radians(-135.0))
    assert scan.angle_max == pytest.approx(np.radians(135.0))
    assert (scan.range_min, scan.range_max) == (0.0, np.inf)
    parents = frames(topics)
    assert parents["r1/lidar"] == {"r1/base_link"}
    assert parents["base_link"] == {"map"}  # of the robot's own transforms


def test_a_replay_of_the_export_has_the_signals_of_the_run(project, driven, export, rocs_bt, monkeypatch):
    bag = export(driven, catalog=Catalog(project))
    monkeypatch.chdir(project)
    told = rocs_bt("replay", "--bag", bag, "--robot", "cart", "--rules", "wall", "--out", "again")
    assert told.code == 0, told.err
    first, again = signal_table(driven, "R2"), signal_table(Recording.open("again"), "cart")
    for name in ("front", "pose", "speed"):
        expected, values = (np.array(each[name].tolist()).reshape(len(each), -1) for each in (first, again))
        known = [np.isclose(expected, row, atol=1e-6, equal_nan=True).all(axis=1).any() for row in values]
        assert len(known) > 10
        assert np.mean(known) > 0.8, name  # a message may have arrived between the reads of two sensors
