"""Enter: a leaf that tells the agent's mode, by which rules live or do not."""

from __future__ import annotations

from py_trees.common import Status

from ..knowledge import Knowledge
from ..trees.nodes import Instant


class Enter(Instant):
    """SUCCESS at once: from now on the attribute `mode` of the agent's own node is this.

    Args:
        name: What displays call it.
        mode: The mode, as rules list it.
        knowledge: The agent's.
    """

    def __init__(self, name: str, mode: str, knowledge: Knowledge) -> None:
        super().__init__(name)
        self.mode = mode
        self._knowledge = knowledge

    def written(self) -> tuple[str, dict[str, str]]:
        return "Enter", {"mode": self.mode}

    def update(self) -> Status:
        self._knowledge.graph.set(self._knowledge.agent, mode=self.mode)
        return Status.SUCCESS
