"""Where a RUNNING tree waits, and what for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ..trees.nodes import Node


def front(root: Behaviour) -> Iterator[tuple[Behaviour, bool]]:
    """RUNNING nodes of a tree, parents before children, each with whether the tree waits in this node itself.

    Below a RUNNING node without RUNNING children the tree waits in the node that was ticked last, such as a condition
    that fails in each tick below a retry.
    """
    todo = [root] if root.status is Status.RUNNING else []
    while todo:
        node = todo.pop()
        running = [child for child in node.children if child.status is Status.RUNNING]
        last = None if running or not node.children else node.tip()
        yield node, not running and last in (None, node)
        if last not in (None, node):
            yield last, True
        todo += reversed(running)


def ancestors(node: Behaviour) -> Iterator[Behaviour]:
    """Parent of a node, its parent, and so on to the root."""
    while (parent := node.parent) is not None:
        yield parent
        node = parent


def until(deadline: float, text: str = "") -> str:
    """Text of a wait with its deadline [s]; without a deadline only the text."""
    return ", ".join(filter(None, (text, f"until {deadline:.2f} s" if math.isfinite(deadline) else "")))


def wait_text(node: Behaviour) -> str:
    """What a node of the front waits for; its feedback if it cannot tell."""
    if isinstance(node, Node):
        with suppress(Exception):  # content may raise anything, and this text is for people only
            return node.wait_text()
    return str(node.feedback_message)
