"""Changes: the stream of status changes of a tree, for recordings, logs and displays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.behaviour import Behaviour

from ..status import IDLE, RUNNING, Outcome
from .node import Node
from .tree import Tree

OnChange = Callable[[int, Outcome, Outcome], None]
"""Takes a node's uid, its outcome before and its outcome now."""


class Changes:
    """Tells what changes, and only that.

    Nodes that ended keep their status in our trees. Here they go back to IDLE as soon as a tick of the tree passes
    them by, so that what is shown is what the last tick did.

    Args:
        tree: Whose changes.
        on_change: Called for each change, children before parents.
    """

    def __init__(self, tree: Tree, on_change: OnChange) -> None:
        self._tree = tree
        self._on_change = on_change
        self._last: dict[Any, Outcome] = {}
        self._ticked: set[Any] = set()
        self._number()
        self._unwatch = tree.watch(self._ticked_node, self._tick_ended)

    def close(self) -> None:
        """Tell nothing more."""
        self._unwatch()

    def _tick_ended(self) -> None:
        """A tick of the tree is over: what ended before it and was not ticked in it is idle."""
        self._renumber_if_edited()
        for node in self._stock:
            self._ticked.add(node.id)
            self._set(node.id, node.status)
        for key in [k for k, v in self._last.items() if v not in (IDLE, RUNNING) and k not in self._ticked]:
            self._set(key, IDLE)
        self._ticked.clear()

    def _renumber_if_edited(self) -> None:
        """See to it that the numbers are those of the tree as it is, which may have been edited."""
        if self._numbered is not self._tree.nodes:
            self._number()

    def _number(self) -> None:
        self._numbered = self._tree.nodes
        self._uids = {node.id: uid for uid, node in enumerate(self._tree.nodes, 1)}
        # py_trees' own nodes tell nobody; they are looked at when the tick is over.
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
