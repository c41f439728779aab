"""Examination of a robot's ROS 2 topics: discovery, types, quality of service, rates, ages and clocks."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

from ...base.clock import WallClock
from ...base.errors import DeviceError, located_at
from ...catalog import RobotSpec
from ...interfaces.device import NOTABLE_AHEAD
from ..devices.actuator_node import NODE as RUN
from ..devices.actuator_node import isolated_node
from ..devices.parameters import Ros2ActuatorParameters, Ros2SensorParameters
from ..messages.message_types import TRANSFORMS
from ..messages.takes import Take
from ..network.connect import open_transport
from ..network.matching import OwnEndpoint
from ..network.node import MAX_AHEAD, RosNode, header_stamp
from ..network.qos import QoS
from ..network.transport import Endpoint, Reader, Sample
from ..settings import Ros2Settings

NODE = "rocs_bt_doctor"
"""Name of the node that examines."""

MAX_OFFSET = MAX_AHEAD
"""Age or clock offset above which a topic has a problem, unless the sensor's `max_age` is smaller [s]."""

RATE = 20.0
"""Rate of sensors that declare none, as in scenarios that declare none [Hz]."""

_POLL = 0.01  # [s]


@dataclass(frozen=True, kw_only=True)
class TopicState:
    """State of a topic of a robot.

    Attributes:
        device: Sensor or actuator in robot.toml; or `emergency_stop` or `go` of the `[ros2]` table.
        topic: Full name of the topic.
        type: Message type of robot.toml.
        nodes: Names of the nodes at the other side with the same type; empty names are unknown nodes.
        qos: Quality of service that robot.toml requests, or for an actuator offers.
        others: Quality of service of these nodes.
        rate: Rate of messages [Hz]; None before the second message.
        age: Smallest time from publication to reception, by both clocks [s]; None without a message.
        header: Time from the stamp in the newest message to its publication [s]; None without a header.
        size: Number of values of the newest message; None without a message.
        matched: Number of subscriptions that match an actuator; None for a sensor.
        problem: Reason why the topic is not usable; empty if it is.
        remark: Notable state that is tolerated, such as another publisher of commands; empty without one.
        kind: Kind of the remark in two words; empty without one.
        optional: Whether the robot may start without it.
    """

    device: str
    topic: str
    type: str
    nodes: tuple[str, ...]
    qos: QoS
    others: tuple[QoS, ...]
    rate: float | None = None
    age: float | None = None
    header: float | None = None
    size: int | None = None
    matched: int | None = None
    problem: str = ""
    remark: str = ""
    kind: str = ""
    optional: bool = False


@dataclass(frozen=True)
class Examination:
    """Result of an examination."""

    transport: str
    distro: str
    domain: int
    network: str
    topics: tuple[TopicState, ...]
    endpoints: tuple[Endpoint, ...]


def examine(robot: RobotSpec | None, settings: Ros2Settings, duration: float = 3.0) -> Examination:
    """Join the network, listen to the topics of a robot, and describe them; nothing is published.

    Args:
        robot: The robot; None to list only what is discovered.
        settings: Settings of the connection.
        duration: Time for discovery and for the measurement of rates [s].

    Raises:
        InputError: A package is not installed, or a message type is unknown.
        DeviceError: The network cannot be joined.
    """
    with closing(open_transport(settings, NODE)) as transport:
        node = RosNode(settings, WallClock(), transport=transport)
        heard = [] if robot is None else [*_sensors(robot, node), *_switches(settings, node)]
        sent = [] if robot is None else [*_actuators(robot, node)]
        end = time.monotonic() + duration
        while time.monotonic() < end:
            for each in heard:
                each.poll()
            time.sleep(_POLL)
        found = (e for e in transport.endpoints() if e.gid not in node.opened)
        endpoints = [e for e in found if e.node.rpartition("/")[2] != NODE]
        topics = (*(each.state(endpoints) for each in heard), *(each.state(endpoints) for each in sent))
        return Examination(
            transport.name,
            node.types.distro,
            settings.domain_id,
            settings.network,
            topics,
            tuple(sorted(endpoints, key=str)),
        )


def _sensors(robot: RobotSpec, node: RosNode) -> Iterator[_Heard]:
    for sensor in robot.sensors:
        if isinstance(given := sensor.parameters, Ros2SensorParameters):
            with located_at(robot.file, sensor.line):
                take = _transforms if given.type == TRANSFORMS else given.make_take(node.types)
                for topic in given.all_topics:
                    reader = node.reader(topic, given.type, given.qos)
                    most = min(MAX_OFFSET, sensor.validity(1.0 / (sensor.rate or RATE)))
                    yield _Heard(sensor.name, node, reader, given.qos, take, most, optional=sensor.optional)


def _switches(settings: Ros2Settings, node: RosNode) -> Iterator[_Heard]:
    """Emergency stop and go, which may have sent nothing yet."""
    for name, topic in (("emergency_stop", settings.emergency_stop), ("go", settings.go)):
        if topic:
            reader = node.reader(topic, "std_msgs/msg/Bool", QoS.SENSOR)
            yield _Heard(name, node, reader, QoS.SENSOR, lambda message: [float(message.data)], seldom=True)


def _actuators(robot: RobotSpec, node: RosNode) -> Iterator[_Sent]:
    for actuator in robot.actuators:
        if isinstance(actuator.parameters, Ros2ActuatorParameters):
            yield _Sent(actuator.name, node, actuator.parameters)


class _Heard:
    """Topic of a sensor."""

    def __init__(
        self,
        device: str,
        node: RosNode,
        reader: Reader,
        qos: QoS,
        take: Take,
        max_offset: float = MAX_OFFSET,
        *,
        seldom: bool = False,
        optional: bool = False,
    ) -> None:
        self._device, self._node, self._reader, self._qos, self._take = device, node, reader, qos, take
        self._max_offset, self._seldom, self._optional = max_offset, seldom, optional
        self._newest: Sample | None = None
        self._stamps: list[float] = []
        self._ages: list[float] = []

    def poll(self) -> None:
        """Take the waiting messages."""
        for sample in self._reader.take_all():
            self._newest = sample
            self._stamps.append(sample.stamp)
            self._ages.append(self._node.transport.now() - sample.stamp)

    def state(self, endpoints: Sequence[Endpoint]) -> TopicState:
        """State of the topic, given the endpoints of the other nodes."""
        found = [e for e in endpoints if e.publishes and e.topic == self._reader.topic and e.type == self._reader.type]
        span = max(self._stamps, default=0.0) - min(self._stamps, default=0.0)
        age = min(self._ages, default=None, key=abs)
        header, size, problem = self._content(endpoints)
        remark = ""
        if not problem and age is not None and (abs(age) > self._max_offset or age < -NOTABLE_AHEAD):
            remark = f"its stamps are {_shift(age)} this computer's clock: synchronise the clocks of both computers"
            problem = remark if abs(age) > self._max_offset else ""
        return TopicState(
            device=self._device,
            topic=self._reader.topic,
            type=self._reader.type,
            nodes=tuple(e.node for e in found),
            qos=self._qos,
            others=tuple(e.qos for e in found),
            rate=(len(self._stamps) - 1) / span if span > 0.0 else None,
            age=age,
            header=header,
            size=size,
            problem=problem,
            remark="" if problem else remark,
            kind="clock offset" if remark and not problem else "",
            optional=self._optional,
        )

    def _content(self, endpoints: Sequence[Endpoint]) -> tuple[float | None, int | None, str]:
        """Header offset [s] and number of values of the newest message, and the problem."""
        if self._newest is None:
            why = self._node.silence(OwnEndpoint(self._reader.topic, self._reader.type, self._qos), endpoints)
            return None, None, "" if self._seldom and why.endswith("published nothing yet") else why
        header = None
        try:
            message = self._node.types.deserialize(self._newest.data, self._reader.type)
            if hasattr(message, "header"):
                header = self._newest.stamp - header_stamp(message)
            return header, len(self._take(message)), ""
        except DeviceError as error:
            return header, None, str(error)


class _Sent:
    """Topic of an actuator; nothing is published on it."""

    def __init__(self, device: str, node: RosNode, given: Ros2ActuatorParameters) -> None:
        self._device, self._node, self._given = device, node, given
        self._writer = node.writer(given.topic, given.type, given.qos)

    def state(self, endpoints: Sequence[Endpoint]) -> TopicState:
        """State of the topic, given the endpoints of the other nodes."""
        writer, offered = self._writer, self._given.qos
        there = [e for e in endpoints if not e.publishes and e.topic == writer.topic]
        found, matched = [e for e in there if e.type == writer.type], writer.matched()
        own = OwnEndpoint(writer.topic, writer.type, offered, publishes=True)
        problem = next(filter(None, map(own.problem, found or there)), "")
        if not there:
            problem = f"no node subscribes to '{writer.topic}'"
        kind, remark = self._publishers(endpoints)
        return TopicState(
            device=self._device,
            topic=writer.topic,
            type=writer.type,
            nodes=tuple(e.node for e in found),
            qos=offered,
            others=tuple(e.qos for e in found),
            matched=matched,
            problem=problem,
            remark=remark,
            kind=kind,
        )

    def _publishers(self, endpoints: Sequence[Endpoint]) -> tuple[str, str]:
        """Kind and text of a remark about the publishers of the topic; empty without one."""
        topic, type = self._writer.topic, self._writer.type
        others = Counter(e.node for e in endpoints if e.publishes and (e.topic, e.type) == (topic, type))
        run = {self._node.settings.topic(name) for name in (RUN, isolated_node(self._device))}
        strangers = {name: count for name, count in others.items() if name not in run or count > 1}
        names = ", ".join(
            f"{count} publishers of {name or 'unknown nodes'}" if count > 1 else name or "an unknown node"
            for name, count in sorted(strangers.items())
        )
        if strangers:
            return "other publisher", f"also published by {names}: these commands override stops"
        return ("in use", f"a run of rocs_bt commands it ({', '.join(sorted(others))})") if others else ("", "")


def _transforms(message: Any) -> list[float]:
    """One value for each transform, as `Take`."""
    return [0.0] * len(message.transforms)


def _shift(age: float) -> str:
    return f"{abs(age):.2f} s {'behind' if age > 0.0 else 'ahead of'}"
