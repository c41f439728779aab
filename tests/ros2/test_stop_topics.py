"""Emergency stop and go by topics."""

from __future__ import annotations

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.ros2.devices.stop_topics import StopTopics
from rocs_bt.ros2.messages.type_store import TypeStore
from rocs_bt.ros2.network import node
from rocs_bt.ros2.network.node import RosNode
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.network.transport import Endpoint
from rocs_bt.ros2.settings import Ros2Settings

from ..waiting import until
from .network import Network

BOOL = "std_msgs/msg/Bool"


class Listener:
    """A host that writes down what is reported."""

    def __init__(self):
        self.heard: list[str] = []

    def emergency_stop(self, reason, source):
        self.heard.append(f"stop by {source}")

    def emergency_released(self, source):
        self.heard.append(f"released by {source}")

    def go(self, by):
        self.heard.append(f"go by {by}")


@pytest.fixture
def network():
    return Network(TypeStore())


@pytest.fixture
def host():
    return Listener()


@pytest.fixture
def topics(network, host):
    settings = Ros2Settings(namespace="r1", emergency_stop="emergency_stop", go="/go")
    return StopTopics(RosNode(settings, SimulatedClock(0.05), transport=network), host)


def test_without_its_publisher_the_robot_is_stopped_until_there_is_one_again(network, host, topics, monkeypatch):
    monkeypatch.setattr(node, "LOOK_AGAIN", 0.01)
    name = "/r1/emergency_stop"

    def polled():
        topics.poll()
        return topics._node.publishers_now(name)

    until(lambda: polled() is not None)
    assert host.heard == []  # before the first publisher the preflight check waits
    network.peers = [Endpoint(name, BOOL, "/button", True, QoS.SENSOR), Endpoint(name, BOOL, "/me", False, QoS.SENSOR)]
    until(lambda: len(polled()) == 1)
    network.peers = [Endpoint(name, "std_msgs/msg/String", "/other", True, QoS.SENSOR), *network.peers[1:]]
    until(lambda: polled()[0].node == "/other")
    topics.poll()
    network.peers = [Endpoint(name, BOOL, "/button", True, QoS.SENSOR)]
    until(lambda: polled()[0].node == "/button")
    topics.poll()
    assert host.heard == [f"stop by publisher of {name}", f"released by publisher of {name}"]


def test_a_press_between_two_looks_is_not_missed(network, host, topics):
    network.send("/r1/emergency_stop", BOOL, age=0.04, data=True)
    network.send("/r1/emergency_stop", BOOL, age=0.02, data=False)
    topics.poll()
    assert host.heard == ["stop by /r1/emergency_stop", "released by /r1/emergency_stop"]
    topics.poll()
    assert len(host.heard) == 2


def test_a_press_with_an_old_stamp_is_not_missed(network, host, topics):
    network.send("/r1/emergency_stop", BOOL, data=False)
    topics.poll()
    network.send("/r1/emergency_stop", BOOL, age=2.0, data=True)  # a pendant with another clock
    topics.poll()
    assert host.heard == ["released by /r1/emergency_stop", "stop by /r1/emergency_stop"]


def test_a_go_that_is_published_again_and_again_is_no_act_of_a_person(network, host, topics):
    for time, data in [(0.0, True), (0.5, True), (1.0, True), (2.5, True), (2.6, False), (2.7, True)]:
        network.time = time
        network.send("/go", BOOL, data=data)
        topics.poll()
    assert len(host.heard) == 3


def test_a_go_together_with_a_message_of_the_emergency_stop_does_not_count(network, host, topics):
    network.send("/go", BOOL, age=0.04, data=True)
    network.send("/r1/emergency_stop", BOOL, age=0.03, data=True)
    network.send("/r1/emergency_stop", BOOL, age=0.01, data=False)
    topics.poll()
    assert [each for each in host.heard if each.startswith("go")] == []


def test_only_true_is_a_go(network, host, topics):
    network.send("/go", BOOL, data=False)
    network.send("/go", BOOL, data=True)
    topics.poll()
    assert host.heard == ["go by topic /go"]


def test_malformed_messages_stop_and_never_let_go(network, host, topics):
    network.send_raw("/r1/emergency_stop", b"\0\1\0\0")
    network.send_raw("/go", b"\0\1\0\0")
    topics.poll()
    assert host.heard == ["stop by /r1/emergency_stop"]


class Heartbeat:
    """Polls the topics each 50 ms, while a publisher sends its value at times [s]."""

    def __init__(self, network, topics, host):
        self.network, self.topics, self.host = network, topics, host

    def send(self, *times, data=False, until=0.0):
        """What is reported up to a time [s], and when the last of it was."""
        begun, at, times = len(self.host.heard), 0.0, list(times)
        while self.network.time < max([until, *times]):
            self.network.time += 0.05
            self.topics._node._clock.advance()
            while times and times[0] <= self.network.time + 1e-6:
                self.network.send("/r1/emergency_stop", BOOL, data=data)
                times.pop(0)
            count = len(self.host.heard)
            self.topics.poll()
            at = self.network.time if len(self.host.heard) > count else at
        return [each for each in self.host.heard[begun:] if "messages" in each], at


@pytest.fixture
def heartbeat(network, topics, host):
    return Heartbeat(network, topics, host)


STOP, RELEASE = "stop by messages of /r1/emergency_stop", "released by messages of /r1/emergency_stop"


@pytest.mark.parametrize(("period", "within"), [(0.05, 1.0), (0.2, 1.0), (0.5, 1.5), (1.0, 3.0), (2.0, 6.0)])
def test_a_repeated_emergency_stop_that_falls_silent_stops_the_robot_until_it_is_repeated_again(
    heartbeat, period, within
):
    times = [period * i for i in range(1, 10)]
    assert heartbeat.send(*times)[0] == []
    heard, at = heartbeat.send(until=times[-1] + 10.0)
    assert heard == [STOP]
    assert within - 1e-6 < at - times[-1] < within + 0.11
    now = heartbeat.network.time
    assert heartbeat.send(*[now + period * i for i in range(1, 4)])[0] == [RELEASE]


def test_one_that_only_sends_changes_or_is_slow_says_nothing_by_its_silence(heartbeat):
    for i in range(10):
        heartbeat.send(heartbeat.network.time + 0.3, data=bool(i % 2))
    assert heartbeat.send(until=heartbeat.network.time + 20.0)[0] == []
    now = heartbeat.network.time
    assert heartbeat.send(*[now + 3.0 * i for i in range(8)], until=now + 60.0)[0] == []


def test_a_press_within_repeated_messages_is_no_silence_and_a_run_that_was_held_up_neither(heartbeat, network):
    heartbeat.send(*[0.1 * i for i in range(1, 20)])
    now = network.time
    assert heartbeat.send(*[now + 0.1 * i for i in range(1, 20)], data=True)[0] == []
    network.time += 30.0
    for _ in range(600):
        heartbeat.topics._node._clock.advance()
    now = network.time
    assert heartbeat.send(*[now + 0.1 * i for i in range(3, 20)], data=True)[0] == []
