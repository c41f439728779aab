"""Messages that an export makes from readings of sensors with `driver = "ros2"`."""

import math

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.event import SensorRead, pack
from rocs_bt.ros2.bags.messages import BagMessages
from rocs_bt.ros2.bags.ros2_sensors import Ros2Topics

from .robots import cart

SENSOR = '[[sensor]]\nname = "{}"\ndriver = "ros2"\nmonitor = "twist"\nsignal = "{}"\n{}\n'


@pytest.fixture
def publish(tmp_path):
    """Function that gives the messages of a cart's additional sensors: name and keys of each, and its readings."""

    def made(sensors, readings):
        more = "".join(SENSOR.format(name, name, keys) for name, keys in sensors.items())
        cart(tmp_path, more=more)
        topics = Ros2Topics(Catalog(tmp_path).load_robot("cart"), BagMessages("", 0.0), 0.05)
        found = []
        for t, sensor, values in readings:
            found += topics.finished(t)
            found += topics.take(SensorRead(t=t, agent="cart", sensor=sensor, stamp=t, data=pack(values)))
        return [*found, *topics.finished(readings[-1][0], over=True)]

    return made


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
