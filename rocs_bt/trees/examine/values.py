"""Static checks of the values that keys have at the beginning: a port that reads one must be able to take it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...base.errors import Fault, InputError
from ..board import Board
from ..nodes import Direction, Node, Port, SubTree, Tree
from ..nodes.tree import fault_at
from .flow import Flow


def initial_value(node: Node, port: Port[Any], flow: Flow) -> Any:
    """Value that a port reads in the first tick; None if there is none, or if a node may change it before."""
    key = node.key(port.name)
    if key is None:
        return node.given.get(port.name)
    if any(use.changes for use in flow.of(node.board, key)):
        return None
    entry = node.board.entry(key)
    return None if entry is None else entry.value


def value_faults(tree: Tree, flow: Flow) -> Iterator[Fault]:
    """Errors of values that no node changes and that a port cannot take, if possible at the SubTree that gives them.

    A literal of the node itself is an error before, when the node is made.
    """
    givers = {tree.boards[node.decorated]: node for node in tree.nodes if isinstance(node, SubTree)}
    reported = set[tuple[Board, str]]()
    for node, port in _inputs(tree):
        key = node.key(port.name)
        # An empty text is no value: checks give it to parameters that they do not know.
        if (
            key is None
            or initial_value(node, port, flow) in (None, "")
            or (place := node.board.resolve(key)) in reported
        ):
            continue
        try:
            node.read(port.name)
        except InputError as error:
            reported.add(place)
            giver, name = givers.get(place[0]), place[1]
            at, attribute = (giver, name) if giver and name in giver.remaps else (node, port.name)
            for f in error.faults:
                yield fault_at(at, f.message, f.hint, attribute=attribute, warning=False)


def _inputs(tree: Tree) -> Iterator[tuple[Node, Port[Any]]]:
    for node in tree.nodes:
        if isinstance(node, Node) and not isinstance(node, SubTree):
            yield from ((node, port) for port in node.ports.values() if port.direction is Direction.INPUT)
