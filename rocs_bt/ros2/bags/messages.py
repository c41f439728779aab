"""Messages of an exported bag, with their names and times."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from ..messages.message_types import MESSAGES, Channel, Values
from ..messages.names import RosNames, robot_namespace


class Published(NamedTuple):
    """Message of a topic.

    Attributes:
        topic: Full name of the topic.
        t: Time of publication [s].
        type: Message type.
        fields: Fields of the message, for `TypeStore.make`.
        latched: Whether late subscriptions need it, so that its durability is transient local.
    """

    topic: str
    t: float
    type: str
    fields: Mapping[str, Any]
    latched: bool = False


class BagMessages(RosNames):
    """Names and times of the messages of one agent.

    Args:
        namespace: Namespace of its topics, and prefix of its frames; empty for none.
        start: Time of the messages at time 0 of the run [s since 1970].
    """

    def __init__(self, namespace: str, start: float) -> None:
        super().__init__(namespace)
        self.start = start

    def topic(self, name: str) -> str:
        """Full name of a topic; an absolute one is without the namespace."""
        return name if name.startswith("/") else super().topic(name)

    def published(self, topic: str, t: float, kind: str, fields: Mapping[str, Any]) -> Published:
        """Message of a topic at a time of the run [s]."""
        return Published(self.topic(topic), self.start + t, kind, fields)

    def measured(self, topic: str, t: float, stamp: float, kind: str, values: Values, channel: Channel) -> Published:
        """Message with values of a short form, published and measured at two times of the run [s]."""
        return self.published(topic, t, kind, MESSAGES[kind].make(self.start + stamp, values, channel))

    def numbers(self, topic: str, t: float, values: Sequence[float]) -> Published:
        """Message with one number or several."""
        if len(values) == 1:
            return self.published(topic, t, "std_msgs/msg/Float64", {"data": values[0]})
        return self.published(topic, t, "std_msgs/msg/Float64MultiArray", {"data": values})

    def text(self, topic: str, t: float, text: str) -> Published:
        """Message with a text."""
        return self.published(topic, t, "std_msgs/msg/String", {"data": text})


def different_namespaces(robots: Iterable[str]) -> dict[str, str]:
    """Namespaces of robots and other bodies, with a number where two would be equal."""
    found: dict[str, str] = {}
    for robot in dict.fromkeys(robots):
        wanted, count = robot_namespace(robot), 1
        while wanted in found.values():
            count += 1
            wanted = f"{robot_namespace(robot)}_{count}"
        found[robot] = wanted
    return found
