"""Where a fault of a node is told: at its element in a document, or by its name."""

from __future__ import annotations

from py_trees.behaviour import Behaviour

from ...errors import Fault
from ..nodes import Node


def fault_at(
    node: Behaviour,
    message: str,
    hint: str = "",
    *,
    attribute: str = "",
    column: int | None = None,
    warning: bool = True,
) -> Fault:
    """A fault of a node, at one of its attributes where it stands in a document.

    Args:
        node: The node.
        message: What is wrong; the node is named before it.
        hint: What to do.
        attribute: The attribute.
        column: Where in the attribute's value, counted from 0.
        warning: Whether the tree still runs.
    """
    told = f"'{node.name}': {message}"
    if isinstance(node, Node) and node.origin is not None:
        found: Fault = node.origin.fault(told, hint, attribute=attribute, column=column, warning=warning)
        return found
    return Fault(told, hint=hint, warning=warning)
