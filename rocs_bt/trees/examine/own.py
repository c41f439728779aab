"""What nodes themselves find wrong with where they stand."""

from __future__ import annotations

from collections.abc import Iterator

from ...errors import Fault, InputError
from ..nodes import Node, Tree
from .place import fault_at


def own_faults(tree: Tree) -> Iterator[Fault]:
    """The doubts of all nodes of a tree, each at its attribute; those that are no warnings keep it from running."""
    for node in tree.nodes:
        if isinstance(node, Node):
            for attribute, fault in _doubts(node):
                column = fault.column - 1 if fault.column and fault.file is None else None
                yield fault_at(
                    node, fault.message, fault.hint, attribute=attribute, column=column, warning=fault.warning
                )


def _doubts(node: Node) -> Iterator[tuple[str, Fault]]:
    """A node's doubts; what keeps it from telling them, such as a port without a value, is one of them."""
    try:
        yield from node.doubts()
    except InputError as error:
        yield from (("", fault) for fault in error.faults)
