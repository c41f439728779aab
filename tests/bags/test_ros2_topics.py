"""Messages that an export makes from readings of sensors with `driver = "ros2"`."""

import itertools
import math

import msgspec
import numpy as np
import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.event import SensorRead, pack
from rocs_bt.record import BodyInfo
from rocs_bt.ros2.bags.messages import BagMessages
from rocs_bt.ros2.bags.sensors import SensorTopics
from rocs_bt.ros2.devices.parameters import Ros2SensorParameters

from ..ros2.test_short_forms import TYPES, draw
from .robots import cart

SENSOR = '[[sensor]]\nname = "{}"\ndriver = "ros2"\nmonitor = "twist"\nsignal = "{}"\n{}\n'


SENSORS = {  # topic, message type, other keys; with those of the cart
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


@pytest.fixture
def publish(tmp_path):
    """Function that gives the messages of a cart's additional sensors: name and keys of each, and its readings."""

    def made(sensors, readings):
        more = "".join(SENSOR.format(name, name, keys) for name, keys in sensors.items())
        cart(tmp_path, more=more)
        robot, body = Catalog(tmp_path).load_robot("cart"), BodyInfo(name="cart", hull=())
        topics = SensorTopics(body, robot, {}, BagMessages("", 0.0), 0.05)
        found = []
        for t, sensor, values, *stamp in readings:
            found += topics.finished(t)
            found += topics.take(SensorRead(t=t, agent="cart", sensor=sensor, stamp=[*stamp, t][0], data=pack(values)))
        return [*found, *topics.finished(readings[-1][0], over=True)]

    return made


def test_each_reading_is_in_a_message_of_its_topic(publish, tmp_path):
    """Readings that several sensors take from one message are in one message again, and repeated ones in none."""
    sensors = {name: f'type = "{type}"\ntopic = "{topic}"\n{keys}' for name, (topic, type, keys) in SENSORS.items()}
    sensors["sonar"] = 'type = "sensor_msgs/msg/Range"\ntopics = ["range/left", "range/right"]\n'
    publish(sensors, [(0.0, "gyro", [0.0])])  # writes the robot
    robot, rng, readings, new = Catalog(tmp_path).load_robot("cart"), np.random.default_rng(3), [], {}
    keys = {s.name: msgspec.convert(s.parameters, Ros2SensorParameters) for s in robot.sensors}
    for k, spec in itertools.product(range(1, 30), robot.sensors):
        given, again = keys[spec.name], [reading for reading in readings if reading[1] == spec.name]
        if again and rng.random() < 0.2:
            readings.append((0.1 * k, *again[-1][1:]))
        else:
            values = draw(rng, given.type, given.taken, given.size)
            values = np.array(values) * given.scale(spec.scale)
            readings.append((0.1 * k, spec.name, values.tolist(), 0.1 * k))
            new[spec.name, k] = values
    messages = {}
    for m in publish(sensors, readings):
        message = TYPES.deserialize(TYPES.serialize(TYPES.make(m.type, **m.fields)), m.type)
        stamp = message.header.stamp if hasattr(message, "header") else None
        k = round(10.0 * (stamp.sec + 1e-9 * stamp.nanosec if stamp else m.t))
        assert messages.setdefault((m.topic, k), message) is message, "two messages"
    scales = {spec.name: keys[spec.name].scale(spec.scale) for spec in robot.sensors}
    for (sensor, k), values in new.items():
        take = keys[sensor].make_take(TYPES)
        found = [take(messages["/" + topic.strip("/"), k]) for topic in keys[sensor].all_topics]
        expected = pytest.approx(values, rel=1e-5, abs=1e-5, nan_ok=True)
        assert np.concatenate(found) * scales[sensor] == expected, sensor
    assert messages.keys() == {("/" + t.strip("/"), k) for sensor, k in new for t in keys[sensor].all_topics}


def test_values_of_two_stamps_are_in_two_messages(publish):
    imu = 'type = "sensor_msgs/msg/Imu"\ntopic = "/imu"\n'
    sensors = {"gyro": imu, "tilt": imu + 'take = "attitude"'}
    found = publish(sensors, [(1.0, "gyro", [0.5]), (1.01, "tilt", [0.1, 0.2])])
    assert [m.fields["header"]["stamp"]["nanosec"] for m in found] == [0, 10_000_000]


def test_an_unknown_value_of_one_topic_makes_no_message_of_it(publish):
    keys = 'type = "std_msgs/msg/String"\ntopics = ["a", "b"]\nwords = ["off", "on"]'
    found = publish({"mode": keys}, [(1.0, "mode", [1.0, math.nan]), (2.0, "mode", [math.nan, 0.0])])
    assert [(m.t, m.topic, m.fields["data"]) for m in found] == [(1.0, "/a", "on"), (2.0, "/b", "off")]


def test_each_transform_of_a_topic_has_its_own_messages(publish):
    tf = 'type = "tf2_msgs/msg/TFMessage"\ntopic = "/tf"\n'
    sensors = {
        "place": tf,
        "heading": tf + 'take = "orientation"',
        "arm": tf + 'frame = "base_link"\nchild = "arm"',
    }
    readings = [(1.0, "place", [1.0, 2.0, 0.0]), (1.0, "arm", [0.1, 0.2, 0.3]), (1.0, "heading", [0.5])]
    found = [m.fields["transforms"] for m in publish(sensors, readings)]
    assert sorted(
        (each["header"]["frame_id"], each["child_frame_id"], *each["transform"]["translation"].values())
        for (each,) in found
    ) == [("base_link", "arm", 0.1, 0.2, 0.3), ("map", "base_link", 1.0, 2.0, 0.0)]


@pytest.mark.parametrize("order", [1, -1])
def test_the_widest_scan_of_a_topic_is_exported(publish, order):
    scan = 'type = "sensor_msgs/msg/LaserScan"\ntopic = "/wide"\n'
    sensors = {"ahead": scan + 'rays = 3\nspan = "90 deg"', "around": scan + 'rays = 5\nspan = "180 deg"'}
    readings = [(1.0, "ahead", [1.0] * 3), (1.0, "around", [2.0] * 5), (1.3, "ahead", [3.0] * 3)]
    (message,) = publish(dict(list(sensors.items())[::order]), readings)
    assert (message.t, list(message.fields["ranges"])) == (1.0, [2.0] * 5)
    assert message.fields["angle_min"] == pytest.approx(-math.pi / 2)


def test_the_newest_word_of_two_sensors_is_exported(publish):
    text = 'type = "std_msgs/msg/String"\ntopic = "/mode"\n'
    sensors = {"power": text + 'words = ["off", "on"]', "mode": text + 'words = ["manual", "auto"]'}
    readings = [(1.0, "mode", [1.0]), (1.0, "power", [math.nan]), (2.0, "mode", [math.nan]), (2.0, "power", [1.0])]
    assert [m.fields["data"] for m in publish(sensors, readings)] == ["auto", "on"]
