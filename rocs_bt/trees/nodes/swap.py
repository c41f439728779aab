"""Functions that replace a subtree of a running tree between two ticks; the blackboards remain."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.composites import Composite
from py_trees.decorators import Decorator

from ...base.errors import Fault, unknown
from ..board import Board
from ..error import TreeError
from .subtree import SubTree


def find_node(nodes: Iterable[Behaviour], paths: Mapping[Any, str], name: str) -> Behaviour:
    """Find a node by its path, or else by its name if only one node has this name.

    Raises:
        TreeError: No node, or more than one, matches.
    """
    nodes = tuple(nodes)
    found = [n for n in nodes if paths[n.id] == name] or [n for n in nodes if n.name == name]
    if not found:
        raise TreeError(unknown("node", name, {node.name for node in nodes}, "The tree"))
    if len(found) > 1:
        places = ", ".join(paths[node.id] for node in found)
        raise TreeError(
            Fault(f"{len(found)} nodes are named '{name}': {places}.", hint="Give the path of one of them.")
        )
    return found[0]


def swapped_part(node: Behaviour) -> Behaviour:
    """Node that a swap replaces: the node; for a SubTree its child, so that remappings and blackboard remain."""
    return node.children[0] if isinstance(node, SubTree) else node


def replace_node(old: Behaviour, new: Behaviour) -> None:
    """Replace a node in its parent."""
    parent, old.parent = old.parent, None
    new.parent = parent
    if parent is None:
        return
    parent.children[next(i for i, child in enumerate(parent.children) if child is old)] = new
    if isinstance(parent, Composite):
        if parent.current_child is old:
            parent.current_child = new
    elif isinstance(parent, Decorator):
        parent.decorated = new


@contextmanager
def keys_restored(board: Board) -> Iterator[None]:
    """Context manager: if its body raises, remove the keys that the body declared on a blackboard and its ancestors."""
    chain = [board]
    while chain[-1].parent is not None:
        chain.append(chain[-1].parent)
    before = [{key for key, _ in one.entries()} for one in chain]
    try:
        yield
    except BaseException:  # an interrupt must restore the blackboards too
        for one, known in zip(chain, before, strict=True):
            for key in {key for key, _ in one.entries()} - known:
                one.unset(key)
        raise
