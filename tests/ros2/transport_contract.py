"""What every pair of transports does; the tests of each environment run it for its pairs."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from rocs_bt.base.errors import DeviceError, InputError
from rocs_bt.ros2.network.connect import open_transport
from rocs_bt.ros2.network.qos import QoS, mismatch
from rocs_bt.ros2.settings import Ros2Settings

DISTRO = os.environ.get("ROS_DISTRO", "jazzy")
PATIENCE = 30.0  # [s]
SCAN = "sensor_msgs/msg/LaserScan"
TEXT = "std_msgs/msg/String"


def until(found: Callable[[], Any]) -> Any:
    """Wait for a true value."""
    end = time.monotonic() + PATIENCE
    while not (value := found()):
        assert time.monotonic() < end, "it never came"
        time.sleep(0.01)
    return value


def meet(writer: Any, reader: Any, data: bytes) -> None:
    """Publish until a message arrives: each side discovers the other by itself. Then take what is on its way."""

    def arrived() -> bool:
        writer.write(data)
        time.sleep(0.05)
        return reader.take() is not None

    until(arrived)
    until(lambda: writer.matched() == 1)
    time.sleep(0.3)
    reader.take()


class TransportContract:
    """Tests of a pair of transports; a subclass names them."""

    sends: str
    receives: str

    @pytest.fixture
    def pair(self, ros_environment):
        sender = open_transport(Ros2Settings(transport=self.sends, distro=DISTRO), "sender")
        receiver = open_transport(Ros2Settings(transport=self.receives, distro=DISTRO), "receiver")
        yield sender, receiver
        sender.close()
        receiver.close()

    def test_only_the_newest_message_is_taken_with_the_time_of_its_publication(self, pair):
        sender, receiver = pair
        reader = receiver.reader("/r1/scan", SCAN, QoS("reliable", "volatile", 5))
        writer = sender.writer("/r1/scan", SCAN, QoS("reliable", "volatile", 5))
        meet(writer, reader, sender.types.serialize(sender.types.make(SCAN)))
        begun, ended = [], []

        def newest():
            """What is taken first of three messages; None if the last of them had not arrived by then."""
            for i in range(3):
                message = sender.types.make(SCAN, ranges=[float(i)] * 720, header={"frame_id": "laser"})
                begun.append(time.time())
                writer.write(sender.types.serialize(message))
                ended.append(time.time())
            time.sleep(0.2)
            first = reader.take()
            time.sleep(0.05)
            return first if reader.take() is None else None

        sample = until(newest)
        message = receiver.types.deserialize(sample.data, SCAN)
        assert (list(message.ranges), message.header.frame_id) == ([2.0] * 720, "laser")
        assert begun[-1] - 0.01 <= sample.stamp <= ended[-1] + 0.01

    def test_a_late_subscription_gets_a_latched_message(self, pair):
        sender, receiver = pair
        writer = sender.writer("/map_name", TEXT, QoS.LATCHED)
        writer.write(sender.types.serialize(sender.types.make(TEXT, data="arena")))
        reader = receiver.reader("/map_name", TEXT, QoS.LATCHED)
        sample = until(reader.take)
        assert receiver.types.deserialize(sample.data, TEXT).data == "arena"

    def test_endpoints_of_other_nodes_are_discovered_with_node_type_and_policies(self, pair):
        sender, receiver = pair
        sender.writer("/scan", SCAN, QoS.SENSOR)
        receiver.reader("/scan", SCAN, QoS("reliable", "volatile", 2))

        def found():
            listed = [e for e in receiver.endpoints() if e.topic == "/scan" and e.node]
            return listed if len(listed) == 2 else None

        theirs, ours = sorted(until(found), key=lambda e: not e.publishes)
        assert (theirs.type, theirs.node, ours.node) == (SCAN, "/sender", "/receiver"), (theirs, ours)
        assert mismatch(theirs.qos, ours.qos) == "reliability (offered best_effort, requested reliable)"

    def test_a_publisher_is_known_by_its_identifier_on_both_sides(self, pair):
        sender, receiver = pair
        ours = [sender.writer("/cmd_vel", TEXT, QoS.COMMAND), receiver.writer("/cmd_vel", TEXT, QoS.COMMAND)]
        again = open_transport(Ros2Settings(transport=self.sends, distro=DISTRO), "sender")  # of the same name
        ours.append(again.writer("/cmd_vel", TEXT, QoS.COMMAND))
        assert len({each.gid for each in ours} - {b""}) == 3
        for side in pair:
            until(lambda side=side: {e.gid for e in side.endpoints() if e.topic == "/cmd_vel"} == {e.gid for e in ours})
        again.close()

    def test_a_namespace_is_part_of_the_name_of_the_node(self, pair, ros_environment):
        _, receiver = pair
        named = open_transport(Ros2Settings(transport=self.sends, distro=DISTRO, namespace="r7"), "base")
        named.writer("/r7/text", TEXT, QoS.COMMAND)
        until(lambda: any(e.node == "/r7/base" for e in receiver.endpoints()))
        named.close()

    def test_a_closed_publisher_says_so_and_an_unknown_type_names_similar_ones(self, pair):
        sender, _ = pair
        writer = sender.writer("/text", TEXT, QoS.COMMAND)
        writer.close()
        with pytest.raises(DeviceError, match="the publisher of '/text' was closed"):
            writer.write(sender.types.serialize(sender.types.make(TEXT)))
        with pytest.raises(InputError, match="Strin"):
            sender.reader("/text", "std_msgs/msg/Strin", QoS.COMMAND)

    def test_threads_may_take_and_write_at_the_same_time(self, pair):
        sender, receiver = pair
        reader = receiver.reader("/numbers", TEXT, QoS("reliable", "volatile", 50))
        writer = sender.writer("/numbers", TEXT, QoS("reliable", "volatile", 50))
        meet(writer, reader, sender.types.serialize(sender.types.make(TEXT)))
        found: list[str] = []
        stop = threading.Event()

        def take():
            while not stop.is_set():
                texts = [receiver.types.deserialize(s.data, TEXT).data for s in reader.take_all()]
                found.extend(filter(None, texts))  # the empty ones are of `meet`
                time.sleep(0.001)

        takers = [threading.Thread(target=take) for _ in range(2)]
        for thread in takers:
            thread.start()
        try:
            for i in range(40):
                writer.write(sender.types.serialize(sender.types.make(TEXT, data=str(i))))
                time.sleep(0.002)
            until(lambda: len(found) == 40)
        finally:
            stop.set()
            for thread in takers:
                thread.join()
        assert sorted(found, key=int) == [str(i) for i in range(40)]
