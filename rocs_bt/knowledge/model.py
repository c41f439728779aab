"""The common part of the three models: views of one Knowledge, with no store of their own."""

from __future__ import annotations

from .base import KnowledgeBase


class Model:
    """A view of Knowledge under a name of its own; a user's subclass adds properties (paper, 5.3).

    Args:
        knowledge: What it is a view of.
    """

    def __init__(self, knowledge: KnowledgeBase) -> None:
        self.knowledge = knowledge
        self.graph = knowledge.graph
        self.signals = knowledge.signals
        self.name = knowledge.agent
