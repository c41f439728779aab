"""Transport: interface to a ROS 2 network, or to a recording of one, which carries raw CDR messages."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from ..messages.type_store import TypeStore
from .qos import QoS


class Sample(NamedTuple):
    """Received message.

    Attributes:
        data: Message as CDR, with its encapsulation header of 4 bytes.
        stamp: Time at which it was published, on the publisher's clock [s since 1970].
    """

    data: bytes
    stamp: float


class Endpoint(NamedTuple):
    """Publisher or subscription that was discovered on the network."""

    topic: str
    type: str
    node: str  # full name; empty if unknown
    publishes: bool
    qos: QoS
    gid: bytes = b""  # empty if unknown

    @property
    def owner(self) -> str:
        """Text with the name of the node, if it is known."""
        return f"the node '{self.node}'" if self.node else "a node"


class Reader(Protocol):
    """Subscription that is polled; thread-safe."""

    topic: str
    type: str

    def take(self) -> Sample | None:
        """Take the newest message since the last call, and drop older ones; None if there is none. Never waits."""

    def take_all(self) -> list[Sample]:
        """Take all messages that are kept, oldest first. Never waits."""

    def close(self) -> None:
        """Close the subscription."""


class Writer(Protocol):
    """Publisher; thread-safe."""

    topic: str
    type: str
    gid: bytes

    def write(self, data: bytes) -> None:
        """Publish a message as CDR, with its encapsulation header.

        Raises:
            DeviceError: The message cannot be sent.
        """

    def matched(self) -> int:
        """Number of subscriptions that match."""

    def close(self) -> None:
        """Close the publisher."""


class Transport(Protocol):
    """Participant of a ROS 2 network. Endpoints are opened from one thread, before the run."""

    name: str  # `rclpy`, `dds` or `bag`
    types: TypeStore

    def reader(self, topic: str, type: str, qos: QoS) -> Reader:
        """Open a subscription.

        Raises:
            InputError: The type is unknown, or the name is not valid.
            DeviceError: The network refuses it.
        """

    def writer(self, topic: str, type: str, qos: QoS) -> Writer:
        """Open a publisher; see `reader`."""

    def endpoints(self) -> list[Endpoint]:
        """Endpoints of all nodes that have been discovered so far, also own ones."""

    def now(self) -> float:
        """Present time on the clock of the samples' stamps [s since 1970]."""

    def close(self) -> None:
        """Close all endpoints and leave the network."""
