"""StopTopics: emergency stop of a robot, and a person's go, by topics of ROS 2."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

from ...base.errors import DeviceError
from ...devices.host import Host
from ..network.node import RosNode
from ..network.qos import QoS
from ..network.transport import Sample

PAUSE = 1.0
"""Time without a message after which true on the topic `go` counts as a new act [s]."""

SILENCE = 1.0
"""Least time without a message after which an emergency stop that repeats its messages counts as lost [s]."""

STOP_TYPE = "std_msgs/msg/Bool"
"""Type of the messages."""

STOP_QOS = QoS("best_effort", "volatile", 10)
"""Quality of service that matches every publisher, but gets no earlier messages."""

_INTERVALS = 3  # after which a repeated message is missing
_SEEN = 5  # intervals in a row after which messages count as repeated
_SLOWEST = 2.5  # [s] longest interval of repeated messages; slower ones may be acts of a person
_TICK = 0.25  # [s] that counts of a pause between two polls, so that a machine or run that was held up is no silence

_LATCHED = QoS("reliable", "transient_local", 1)  # gets the last message of a latched topic


class StopTopics:
    """Emergency stop and go of the topics that the `[ros2]` table names; both carry std_msgs/msg/Bool.

    True on the topic of the emergency stop stops the robot, whatever its stamp, and false releases it. The topic should
    have one publisher, because a false of another one releases the robot too.

    If the last publisher of the emergency stop disappears, the robot is stopped until there is one again. A publisher
    that was killed disappears only after the lease of its participant. The robot is therefore also stopped if messages
    that were repeated are missing; see `Repetition`.

    True on the topic `go` lets the robot move again. It must be the act of a person, so it counts only after false or
    after a second without a message, and not together with a message of the emergency stop.

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
        self._repetition, self._silent = Repetition(), False
        for reader in self._stop:
            node.watch(reader.topic)
        self._pressed = (False, -math.inf)  # last value on the topic `go`, and its stamp [s since 1970]

    def poll(self) -> None:
        """Report new messages; called once per control period."""
        found = {sample for reader in self._stop for sample in reader.take_all()}.difference(self._seen)
        self._seen.extend(found)
        values = []
        for sample in sorted(found, key=lambda sample: sample.stamp):
            topic = self._stop[0].topic
            values.append(self._value(sample, topic, malformed=True))
            if values[-1]:
                self._host.emergency_stop(f"topic {topic}", topic)
            else:
                self._host.emergency_released(topic)
        if self._stop:
            self._watch_publisher(self._stop[0].topic)
            self._watch_repetition(self._stop[0].topic, values)
        for reader in self._go:
            for sample in reader.take_all():
                pressed = self._value(sample, reader.topic, malformed=False)
                before, at = self._pressed
                self._pressed = (pressed, sample.stamp)
                if pressed and (not before or sample.stamp - at >= PAUSE) and not found:
                    self._host.go(f"topic {reader.topic}")

    def _watch_publisher(self, topic: str) -> None:
        source = f"publisher of {topic}"
        if (found := self._node.publishers_now(topic)) is None:
            return
        if any(each.type == STOP_TYPE for each in found):
            if self._gone:
                self._host.emergency_released(source)
            self._published, self._gone = True, False
        elif self._published and not self._gone:
            self._gone = True
            self._host.emergency_stop(f"no node publishes {topic} any more", source)

    def _watch_repetition(self, topic: str, values: Sequence[bool]) -> None:
        source, silent = f"messages of {topic}", self._repetition.lost(self._node.received(), values)
        if silent and not self._silent:
            reason = f"no message on {topic} for {self._repetition.limit:.1f} s, which were repeated before"
            self._host.emergency_stop(reason, source)
        elif self._silent and not silent:
            self._host.emergency_released(source)
        self._silent = silent

    def _value(self, sample: Sample, topic: str, *, malformed: bool) -> bool:
        """Value of a message; `malformed` if it cannot be read."""
        try:
            return bool(self._node.types.deserialize(sample.data, STOP_TYPE).data)
        except DeviceError as error:
            self._node.fault(topic, "malformed", error)
            return malformed


class Repetition:
    """Interval of a publisher that repeats its value, and the time since its last message.

    A publisher that sends a message only when its value changes repeats nothing, so that its silence means nothing.

    Attributes:
        limit: Time without a message after which the publisher is lost [s]; +inf while nothing is repeated.
    """

    def __init__(self) -> None:
        self._intervals: deque[float] = deque(maxlen=_SEEN)
        self._last: bool | None = None
        self._polled = math.nan  # [s]
        self._silence = 0.0  # [s]

    @property
    def limit(self) -> float:
        return max(SILENCE, _INTERVALS * max(self._intervals)) if len(self._intervals) == _SEEN else math.inf

    def lost(self, now: float, values: Sequence[bool]) -> bool:
        """Whether the publisher is lost.

        Args:
            now: Present time [s].
            values: Values of the messages since the last call.
        """
        if math.isfinite(self._polled):
            self._silence += min(now - self._polled, _TICK)
        self._polled = now
        if values:
            if self._silence > _SLOWEST:
                self._intervals.clear()
            elif all(value == self._last for value in values):
                self._intervals.append(self._silence)
            self._last, self._silence = values[-1], 0.0
        return self._silence > self.limit
