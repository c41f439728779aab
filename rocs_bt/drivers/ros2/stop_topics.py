"""StopTopics: emergency stop of a robot, and a person's go, by topics of ROS 2."""

from __future__ import annotations

import math
from collections import deque

from ...errors import DeviceError
from ..host import Host
from .node import RosNode
from .qos import QoS
from .transport import Sample

PAUSE = 1.0
"""Time without a message after which true on the topic `go` counts as a new act [s]."""

STOP_TYPE = "std_msgs/msg/Bool"
"""Type of the messages."""

STOP_QOS = QoS("best_effort", "volatile", 10)
"""Quality of service that matches every publisher, but gets no earlier messages."""

_LATCHED = QoS("reliable", "transient_local", 1)  # gets the last message of a latched topic


class StopTopics:
    """Emergency stop and go of the topics that the `[ros2]` table names; both carry std_msgs/msg/Bool.

    True on the topic of the emergency stop stops the robot, whatever its stamp, and false releases it. The topic should
    have one publisher, because a false of another one releases the robot too.

    If the last publisher of the emergency stop disappears, the robot is stopped until one publishes again.

    True on the topic `go` lets the robot move again. It must be the act of a person, so it counts only after false or
    after a second without a message, and not together with a message of the emergency stop.

    Args:
        node: Connection of the robot.
        host: Host of the robot's devices, to which stops and goes are reported.

    Raises:
        DeviceError: The network refuses a subscription.
    """

    def __init__(self, node: RosNode, host: Host) -> None:
        self._node = node
        self._host = host
        settings = node.settings
        # A go that was published before the run must not count, so its topic is not read as a latched one.
        wanted = ((settings.emergency_stop, (STOP_QOS, _LATCHED)), (settings.go, (STOP_QOS,)))
        self._stop, self._go = ([node.reader(topic, STOP_TYPE, qos) for qos in each if topic] for topic, each in wanted)
        self._seen: deque[Sample] = deque(maxlen=100)  # messages that arrive on both subscriptions count once
        self._published = self._gone = False  # whether the emergency stop has had a publisher, and lost it
        self._pressed = (False, -math.inf)  # last value on the topic `go`, and its stamp [s since 1970]

    def poll(self) -> None:
        """Report new messages; called once per control period."""
        found = {sample for reader in self._stop for sample in reader.take_all()}.difference(self._seen)
        self._seen.extend(found)
        for sample in sorted(found, key=lambda sample: sample.stamp):
            topic = self._stop[0].topic
            if self._value(sample, topic, malformed=True):
                self._host.emergency_stop(f"topic {topic}", topic)
            else:
                self._host.emergency_released(topic)
        if self._stop:
            self._watch_publisher(self._stop[0].topic)
        for reader in self._go:
            for sample in reader.take_all():
                pressed = self._value(sample, reader.topic, malformed=False)
                before, at = self._pressed
                self._pressed = (pressed, sample.stamp)
                if pressed and (not before or sample.stamp - at >= PAUSE) and not found:
                    self._host.go(f"topic {reader.topic}")

    def _watch_publisher(self, topic: str) -> None:
        source = f"publisher of {topic}"
        if (count := self._node.publishers_now(topic)) is None:
            return
        if count:
            if self._gone:
                self._host.emergency_released(source)
            self._published, self._gone = True, False
        elif self._published and not self._gone:
            self._gone = True
            self._host.emergency_stop(f"no node publishes {topic} any more", source)

    def _value(self, sample: Sample, topic: str, *, malformed: bool) -> bool:
        """Value of a message; `malformed` if it cannot be read."""
        try:
            return bool(self._node.types.deserialize(sample.data, STOP_TYPE).data)
        except DeviceError as error:
            self._node.fault(topic, "malformed", error)
            return malformed
