"""CommandWatch: publishers of an actuator's topic that are not part of the run."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from ..network.node import RosNode
from ..network.transport import Endpoint


class CommandWatch:
    """Reports other publishers of a robot's command topic, each once: their commands override stops.

    Nodes with another message type do not reach the robot.
    """

    def __init__(
        self, node: RosNode, topic: str, type: str, own: Collection[bytes], report: Callable[[str], None]
    ) -> None:
        self._node = node
        self._topic = topic
        self._type = type
        self._own = own
        self._report = report
        self._looked: Sequence[Endpoint] | None = None
        self._nameless: set[bytes] = set()
        self._known: set[bytes] = set()
        node.watch(topic)

    def poll(self) -> None:
        """Report new publishers of the last look; called once per control period."""
        found = self._node.publishers_now(self._topic)
        if found is None or found is self._looked:
            return
        self._looked = found
        for each in found:
            if each.type != self._type or any(each.gid in own for own in (self._known, self._own, self._node.opened)):
                continue
            if each.node or each.gid in self._nameless:  # the name may be discovered after the publisher
                self._known.add(each.gid)
                self._report(each.owner)
            self._nameless.add(each.gid)
