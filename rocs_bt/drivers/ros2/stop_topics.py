"""StopTopics: emergency stop of a robot, and a person's go, by topics of ROS 2."""

from __future__ import annotations

from ...errors import DeviceError
from ..host import Host
from .node import RosNode
from .qos import QoS
from .transport import Sample

_BOOL = "std_msgs/msg/Bool"
_ANY = QoS("best_effort", "volatile", 10)  # matches every publisher, but gets no earlier messages
_LATCHED = QoS("reliable", "transient_local", 10)  # gets the last message of a latched topic


class StopTopics:
    """Emergency stop and go of the topics that the `[ros2]` table names; both carry std_msgs/msg/Bool.

    True on the topic of the emergency stop stops the robot, and false releases it. True on the topic `go` lets it move
    again.

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
        wanted = ((settings.emergency_stop, (_ANY, _LATCHED)), (settings.go, (_ANY,)))
        self._stop, self._go = ([node.reader(topic, _BOOL, qos) for qos in each if topic] for topic, each in wanted)
        self._newest = 0.0  # [s since 1970] stamp of the newest message of the emergency stop

    def poll(self) -> None:
        """Report new messages, in the order of their publication; called once per control period."""
        found = {sample for reader in self._stop for sample in reader.take_all() if sample.stamp > self._newest}
        for sample in sorted(found, key=lambda sample: sample.stamp):
            self._newest, topic = sample.stamp, self._stop[0].topic
            if self._value(sample, topic, malformed=True):
                self._host.emergency_stop(f"topic {topic}", topic)
            else:
                self._host.emergency_released(topic)
        for reader in self._go:
            for sample in reader.take_all():
                if self._value(sample, reader.topic, malformed=False):
                    self._host.go(f"topic {reader.topic}")

    def _value(self, sample: Sample, topic: str, *, malformed: bool) -> bool:
        """Value of a message; `malformed` if it cannot be read."""
        try:
            return bool(self._node.types.deserialize(sample.data, _BOOL).data)
        except DeviceError as error:
            self._node.fault(topic, "malformed", error)
            return malformed
