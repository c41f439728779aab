"""The common part of the three models: views of one Knowledge, with no store of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .knowledge import Knowledge


class Model:
    """A view of Knowledge under a name of its own; a user's subclass adds properties (paper, 5.3).

    Args:
        knowledge: What it is a view of.
    """

    def __init__(self, knowledge: Knowledge) -> None:
        self.knowledge = knowledge
        self.graph = knowledge.graph
        self.signals = knowledge.signals
        self.name = knowledge.agent
