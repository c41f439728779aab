"""NetworkWatch: notices of nodes that do not match the topics of simulated robots."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator

from ..network.qos import QoS, mismatch
from ..network.transport import Endpoint, Transport

LOOK_AGAIN = 1.0
"""Wall-clock time between two looks at the network [s]."""


class NetworkWatch:
    """Looks for nodes with a type or quality of service that does not match a topic; each is noticed once.

    Args:
        transport: Network.
        published: Topics that the simulation publishes, each with its type and the quality of service offered.
        taken: Topics of commands that the simulation takes, each with its type and the quality of service requested.
        notice: Function that is called with each notice.
        wall: Wall clock [s].
    """

    def __init__(
        self,
        transport: Transport,
        published: Iterable[tuple[str, str, QoS]],
        taken: Iterable[tuple[str, str, QoS]],
        notice: Callable[[str], None],
        wall: Callable[[], float] = time.monotonic,
    ) -> None:
        self._transport = transport
        self._published = {topic: (type, qos) for topic, type, qos in published}
        self._taken = {topic: (type, qos) for topic, type, qos in taken}
        self._notice = notice
        self._wall = wall
        self._next = wall() + LOOK_AGAIN
        self._known: set[str] = set()

    def look(self) -> None:
        """Look at the network if it is time."""
        if self._wall() < self._next:
            return
        for endpoint in self._transport.endpoints():
            for text in self._mismatches(endpoint):
                if text not in self._known:
                    self._known.add(text)
                    self._notice(text)
        self._next = self._wall() + LOOK_AGAIN

    def _mismatches(self, each: Endpoint) -> Iterator[str]:
        node = each.owner
        type, qos = (self._taken if each.publishes else self._published).get(each.topic, (each.type, each.qos))
        verb = "publishes" if each.publishes else "subscribes to"
        if each.type != type:
            yield f"{each.topic}: {node} {verb} {each.type}, and the type here is {type}.{_advice(each)}"
        elif why := mismatch(each.qos, qos) if each.publishes else mismatch(qos, each.qos):
            fix = f"Let it {'offer' if each.publishes else 'request'} {qos.reliability}, {qos.durability}."
            yield f"{each.topic}: the quality of service of {node} does not match in {why}. {fix}"


def _advice(each: Endpoint) -> str:
    """What to do about commands of another type."""
    name = each.type.removeprefix("geometry_msgs/msg/")
    return f" Write --cmd-vel {name}." if each.publishes and name in ("Twist", "TwistStamped") else ""
