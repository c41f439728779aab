"""PassMessages: whether somebody said something."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from ..channel import Signals, Stamped
from ..event import Change
from .analyze import Analyze


class PassMessages(Analyze):
    """Tells Plan of each message that has come: a Change of kind `message` about its sender, with its text."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._told = 0

    def expects(self) -> Sequence[str]:
        return ("messages",)

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        graph = self.knowledge.graph
        for sample in samples:
            if "messages" not in sample.value or math.isnan(sample.value["messages"][0]):
                continue
            while self._told < sample.value["messages"][0]:
                self._told += 1
                node = f"message {self._told}"
                if graph.has(node):  # else it is among the oldest of too many at once
                    said = graph.attributes(node)
                    yield self.change(sample.t, "message", said["sender"], text=said["text"], node=node)
