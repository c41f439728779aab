"""A ROS 2 network in memory: the same interface as the real transports, with a clock that the test moves."""

from __future__ import annotations

from collections import deque
from typing import Any

from rocs_bt.ros2.messages.type_store import TypeStore
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.network.transport import Endpoint, Sample

START = 1.8e9  # [s since 1970]


class Network:
    """Transport of one node, whose peers are the test itself.

    Attributes:
        published: Messages that the node has written, by topic.
        time: Present time since the start [s].
        matches: Number of subscriptions that match each publisher.
    """

    name = "memory"

    def __init__(self, types: TypeStore) -> None:
        self.types = types
        self.time = 0.0
        self.published: dict[str, list[Any]] = {}
        self.peers: list[Endpoint] = []
        self.matches = 1
        self._queues: dict[str, list[deque[Sample]]] = {}

    def send(self, topic: str, type: str, age: float = 0.0, **values: Any) -> None:
        """Publish a message for the node, which is `age` seconds old."""
        self.send_raw(topic, self.types.serialize(self.types.make(type, **values)), age)

    def send_raw(self, topic: str, data: bytes, age: float = 0.0) -> None:
        for queue in self._queues.get(topic, []):
            queue.append(Sample(data, self.now() - age))

    def reader(self, topic: str, type: str, qos: QoS) -> Any:
        self.types.message(type)
        queue: deque[Sample] = deque(maxlen=qos.depth)
        self._queues.setdefault(topic, []).append(queue)
        return _Reader(topic, type, queue)

    def writer(self, topic: str, type: str, qos: QoS) -> Any:
        return _Writer(self, topic, type)

    def endpoints(self) -> list[Endpoint]:
        return self.peers

    def now(self) -> float:
        return START + self.time

    def close(self) -> None:
        self._queues.clear()


class _Reader:
    def __init__(self, topic: str, type: str, queue: deque[Sample]) -> None:
        self.topic, self.type, self._queue = topic, type, queue

    def take(self) -> Sample | None:
        found = self.take_all()
        return found[-1] if found else None

    def take_all(self) -> list[Sample]:
        return [self._queue.popleft() for _ in range(len(self._queue))]  # a thread may send meanwhile

    def close(self) -> None:
        self._queue.clear()


class _Writer:
    def __init__(self, network: Network, topic: str, type: str) -> None:
        self.topic, self.type, self._network = topic, type, network
        self.gid = f"{topic} {id(self)}".encode()

    def write(self, data: bytes) -> None:
        self._network.published.setdefault(self.topic, []).append(self._network.types.deserialize(data, self.type))

    def matched(self) -> int:
        return self._network.matches

    def close(self) -> None:
        pass
