"""Messages that an export makes from readings of sensors with `driver = "ros2"`."""

import math

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.event import SensorRead, pack
from rocs_bt.simulation.bag_messages import BagMessages
from rocs_bt.simulation.recorded_ros2 import Ros2Topics

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
