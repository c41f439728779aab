"""Other publishers of a robot's command topic."""

from __future__ import annotations

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.ros2.devices.command_watch import CommandWatch
from rocs_bt.ros2.messages.type_store import TypeStore
from rocs_bt.ros2.network import node
from rocs_bt.ros2.network.node import RosNode
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.network.transport import Endpoint
from rocs_bt.ros2.settings import Ros2Settings

from ..waiting import until
from .network import Network

TWIST, TOPIC = "geometry_msgs/msg/Twist", "/r1/cmd_vel"


def publisher(name="", gid=b"x", type=TWIST, topic=TOPIC, publishes=True):
    return Endpoint(topic, type, name, publishes, QoS.COMMAND, gid)


class Watched:
    """A robot with a publisher of its own, and another one in the process of its actuator."""

    def __init__(self):
        self.network = Network(TypeStore())
        self.node = RosNode(Ros2Settings(namespace="r1"), SimulatedClock(0.05), transport=self.network)
        writer = self.node.writer("cmd_vel", TWIST, QoS.COMMAND)
        self.own = [publisher("/r1/rocs_bt", writer.gid), publisher("/r1/rocs_bt_wheels", b"isolated")]
        self.reported: list[str] = []
        self.watch = CommandWatch(self.node, TOPIC, TWIST, {b"isolated"}, self.reported.append)

    def see(self, *others: Endpoint) -> list[str]:
        """What is reported in two looks at a network with our own publishers and others."""
        before = len(self.reported)
        for _ in range(2):
            self.network.peers = [*self.own, *others]
            seen = [e for e in self.network.peers if e.topic == TOPIC and e.publishes]
            until(lambda seen=seen: self.node.publishers_now(TOPIC) == seen)
            self.watch.poll()
            last = self.node.publishers_now(TOPIC)
            until(lambda last=last: self.node.publishers_now(TOPIC) is not last)
            self.watch.poll()
        return self.reported[before:]


@pytest.fixture
def watched(monkeypatch):
    monkeypatch.setattr(node, "LOOK_AGAIN", 0.005)
    made = Watched()
    yield made
    made.node.close()


def test_our_own_publishers_and_nodes_that_do_not_command_are_not_reported(watched):
    harmless = [
        publisher("/teleop", type="geometry_msgs/msg/TwistStamped"),
        publisher("/teleop", topic="/r2/cmd_vel"),
        publisher("/base", publishes=False),
    ]
    assert watched.see(*harmless) == []


def test_each_other_publisher_is_reported_once_also_with_the_name_of_our_node(watched):
    teleop, run = publisher("/teleop", b"a"), publisher("/r1/rocs_bt", b"b")
    assert watched.see(teleop) == ["the node '/teleop'"]
    assert watched.see(teleop, run) == ["the node '/r1/rocs_bt'"]
    assert watched.see(run) == []
    assert watched.see(publisher("/teleop", b"c")) == ["the node '/teleop'"]  # started again


def test_a_name_that_is_discovered_late_is_waited_for(watched):
    watched.network.peers = [publisher("", b"a")]
    until(lambda: watched.node.publishers_now(TOPIC))
    watched.watch.poll()
    assert watched.reported == []
    assert watched.see(publisher("/teleop", b"a")) == ["the node '/teleop'"]


def test_a_publisher_without_a_name_is_reported(watched):
    assert watched.see(publisher("", b"a")) == ["a node"]
