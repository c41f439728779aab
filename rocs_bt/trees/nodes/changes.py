"""Changes: stream of status changes of a tree, for recordings, logs and displays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.behaviour import Behaviour

from ..status import IDLE, RUNNING, Outcome
from .node import Node
from .tree import Tree

OnChange = Callable[[int, Outcome, Outcome], None]
"""Callback for a change of status; arguments: the node's uid, its previous outcome and its new outcome."""


class Changes:
    """Reports each change of a node's status to a callback.

    Nodes that have ended keep their status in the tree. This class reports such a node as IDLE after the first tick of
    the tree that does not reach it, so that a display shows only the last tick.

    Args:
        tree: Observed tree.
        on_change: Callback for each change, children before parents.
    """

    def __init__(self, tree: Tree, on_change: OnChange) -> None:
        self._tree = tree
        self._on_change = on_change
        self._last: dict[Any, Outcome] = {}
        self._ticked: set[Any] = set()
        self._number()
        self._unwatch = tree.watch(self._ticked_node, self._tick_ended)

    def close(self) -> None:
        """Stop reporting."""
        self._unwatch()

    def _tick_ended(self) -> None:
        """Report as IDLE each node that had ended before this tick and was not reached by it."""
        self._renumber_if_edited()
        for node in self._stock:
            self._ticked.add(node.id)
            self._set(node.id, node.status)
        for key in [k for k, v in self._last.items() if v not in (IDLE, RUNNING) and k not in self._ticked]:
            self._set(key, IDLE)
        self._ticked.clear()

    def _renumber_if_edited(self) -> None:
        """Update the uids if the tree was edited."""
        if self._numbered is not self._tree.nodes:
            self._number()

    def _number(self) -> None:
        self._numbered = self._tree.nodes
        self._uids = {node.id: uid for uid, node in enumerate(self._tree.nodes, 1)}
        # Stock py_trees nodes do not report ticks; their status is read at the end of each tick.
        self._stock = [node for node in self._tree.nodes if not isinstance(node, Node)]
        self._last = {key: last for key, last in self._last.items() if key in self._uids}

    def _ticked_node(self, node: Behaviour, outcome: Outcome) -> None:
        self._ticked.add(node.id)
        self._set(node.id, outcome)

    def _set(self, key: Any, outcome: Outcome) -> None:
        before = self._last.get(key, IDLE)
        if outcome is not before:
            self._renumber_if_edited()
            self._last[key] = outcome
            self._on_change(self._uids[key], before, outcome)
