"""MessageMonitor: messages from other robots."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Annotated

from ..base.signal import Signal
from ..base.units import NONE, Bounds
from ..interfaces.channel import Signals
from ..interfaces.device import Reading
from ..interfaces.message import ReceivedMessage, unpacked
from .monitor import Monitor


class MessageMonitor(Monitor):
    """Writes `messages`, the number of received messages, and adds a `message` node for each.

    Attributes:
        max_messages: Number of the newest messages that Knowledge keeps.
    """

    max_messages: Annotated[int, Bounds(1)] = 32

    def __post_init__(self) -> None:
        self._count = 0
        self._nodes: deque[str] = deque()

    def signals(self) -> Sequence[Signal]:
        return [Signal("messages", 1, (NONE,), (0.0, math.inf), self.max_age, "Number of received messages.")]

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        for reading in readings.values():
            for letter in unpacked(reading.values):
                self._remember(letter)
        return {"messages": [float(self._count)]}

    def _remember(self, letter: ReceivedMessage) -> None:
        self._count += 1
        graph, node = self.knowledge.graph, f"message {self._count}"
        graph.add(node, "message", sender=letter.sender, text=letter.text, number=self._count)
        self._nodes.append(node)
        if len(self._nodes) > self.max_messages and graph.has(old := self._nodes.popleft()):
            graph.remove(old)
