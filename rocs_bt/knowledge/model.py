"""Base class of the three models: named views of one Knowledge without a store of their own."""

from __future__ import annotations

from .base import KnowledgeBase


class Model:
    """View of Knowledge; a user's subclass adds properties (paper, 5.3)."""

    def __init__(self, knowledge: KnowledgeBase) -> None:
        self.knowledge = knowledge
        self.graph = knowledge.graph
        self.signals = knowledge.signals
        self.name = knowledge.agent
