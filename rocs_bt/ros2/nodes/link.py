"""NodeLink: the ROS connection of a robot for the nodes of its mission."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ...base.errors import DeviceError, Fault, InputError
from ..messages.known_types import KnownTypes
from ..messages.plain import PlainMessage
from ..network.matching import OwnEndpoint, Side
from ..network.node import MAX_AHEAD, RosNode, of_the_future
from ..network.qos import QoS
from ..network.rclpy_transport import RclpyTransport
from ..network.transport import Reader, Sample, Writer
from ..ros_link import (
    Received,
    RosActionClient,
    RosActionServer,
    RosPublisher,
    RosServiceClient,
    RosSubscription,
    RosTrigger,
)

if TYPE_CHECKING:
    from ..network.services import RosServices

_QOS = {"reliable": QoS("reliable", "volatile", 10), "sensor_data": QoS.SENSOR, "latched": QoS.LATCHED}
_SIDE = Side("the node", qualities=_QOS)

_NO_RCLPY = (
    "services and actions of ROS 2 need rclpy, and this connection uses DDS without ROS: the vendors of DDS send the "
    "headers of requests differently, so that servers of another vendor ignore them."
)


class NodeLink:
    """ROS connection of a robot for the nodes of its mission; see `RosLink`.

    Args:
        connect: Function that returns the connection of the robot's sensors and actuators; it is called if the mission
            has nodes that use ROS.
        notice: Function that is called at the end for each goal that may go on, with the reason; None for none.
    """

    def __init__(self, connect: Callable[[], RosNode], notice: Callable[[str], None] | None = None) -> None:
        self._connect = connect
        self._notice = notice or (lambda text: None)
        self._services: RosServices | None = None
        self._lock = threading.RLock()

    @cached_property
    def types(self) -> KnownTypes:
        """Types that the connection knows."""
        return KnownTypes(self._node.types)

    @cached_property
    def _node(self) -> RosNode:
        with self._lock:
            return self._connect()

    def publisher(self, topic: str, type: str, qos: str) -> RosPublisher:
        with self._lock:
            return _Publisher(self._node, self._node.writer(topic, type, _QOS[qos]), _QOS[qos])

    def subscription(self, topic: str, type: str, qos: str) -> RosSubscription:
        with self._lock:
            return _Subscription(self._node, self._node.reader(topic, type, _QOS[qos]), _QOS[qos])

    def service(self, name: str, type: str) -> RosServiceClient:
        return self._rclpy(f"'{name}'").service(self._node.settings.topic(name), type)

    def action(self, name: str, type: str) -> RosActionClient:
        return self._rclpy(f"'{name}'").action(self._node.settings.topic(name), type)

    def action_server(self, name: str, type: str) -> RosActionServer:
        return self._rclpy(f"'{name}'").action_server(self._node.settings.topic(name), type)

    def trigger(self, name: str) -> RosTrigger:
        return self._rclpy(f"'{name}'").trigger(self._node.settings.topic(name))

    def close(self) -> None:
        """Send what is still to be sent, such as cancellations, and close the services and actions."""
        with self._lock:
            if self._services is not None:
                left, self._services = self._services.close(), None
                for reason in left:
                    self._notice(f"{reason}.")

    def _rclpy(self, name: str) -> RosServices:
        from ..network.services import RosServices

        with self._lock:
            if self._services is None:
                transport = self._node.transport
                if not isinstance(transport, RclpyTransport):
                    hint = 'Source an installation of ROS 2, and write transport = "rclpy" or "auto" in [ros2].'
                    raise InputError(Fault(f"{name} cannot be used: {_NO_RCLPY}", hint=hint))
                self._services = RosServices(transport.context, self._node.settings.namespace)
            return self._services


class _Publisher:
    def __init__(self, node: RosNode, writer: Writer, qos: QoS) -> None:
        self._node = node
        self._types = node.types
        self._writer = writer
        self._own = OwnEndpoint(writer.topic, writer.type, qos, publishes=True, side=_SIDE)
        node.begin_lookout()
        node.why_unmatched(self._own)  # so that the endpoints are looked up before they are asked for

    def matched(self) -> int:
        return self._writer.matched()

    def mismatch(self) -> str:
        return self._node.why_unmatched(self._own)

    def publish(self, values: Mapping[str, Any]) -> None:
        try:
            data = self._types.serialize(self._types.make(self._writer.type, **values))
        except (TypeError, ValueError, OverflowError, AssertionError) as error:
            raise DeviceError(f"no {self._writer.type} can be made of {dict(values)!r:.80}: {error}") from error
        self._writer.write(data)

    def close(self) -> None:
        self._writer.close()


class _Subscription:
    def __init__(self, node: RosNode, reader: Reader, qos: QoS) -> None:
        self.ignored = ""
        self._own = OwnEndpoint(reader.topic, reader.type, qos, side=_SIDE)
        node.why_unmatched(self._own)  # so that the endpoints are looked up before they are asked for
        self._node = node
        self._reader = reader
        self._newest: tuple[PlainMessage, float, float] | None = None  # message, stamp and time of the take [s]
        self._count = 0

    def newest(self) -> Received | None:
        if (sample := self._reader.take()) is not None:
            try:
                self._newest = self._message(sample), sample.stamp, self._node.received()
                self._count += 1
                self.ignored = ""
            except DeviceError as error:
                self.ignored = str(error)
        if self._newest is None:
            return None
        message, stamp, taken = self._newest
        age = max(self._node.transport.now() - stamp, self._node.received() - taken, 0.0)
        return Received(message, age, self._count)

    def mismatch(self) -> str:
        return self._node.why_unmatched(self._own)

    def _message(self, sample: Sample) -> PlainMessage:
        """Message of a sample; a faulty one, or one of the future, is counted and raises DeviceError."""
        topic, ahead = self._reader.topic, sample.stamp - self._node.transport.now()
        if ahead > MAX_AHEAD:
            raise self._node.fault(topic, "stamp", of_the_future(ahead))
        try:
            return PlainMessage(self._node.types.deserialize(sample.data, self._reader.type))
        except DeviceError as error:
            raise self._node.fault(topic, "malformed", error) from error

    def close(self) -> None:
        self._reader.close()
