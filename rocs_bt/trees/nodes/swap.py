"""Swapping a subtree of a running tree between two ticks: one leaves, another comes, the boards stay."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.composites import Composite
from py_trees.decorators import Decorator

from ...errors import Fault, unknown
from ..board import Board
from ..error import TreeError
from .subtree import SubTree


def find_node(nodes: Iterable[Behaviour], paths: Mapping[Any, str], name: str) -> Behaviour:
    """The node that has a path, or else the only one that has a name.

    Args:
        nodes: Where to look.
        paths: Their paths by `id`.
        name: A path or a name.

    Raises:
        TreeError: There is none, or there are several.
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
    """What a swap of a node exchanges: of a SubTree the tree in it, so that its remappings and its board stay."""
    return node.children[0] if isinstance(node, SubTree) else node


def replace_node(old: Behaviour, new: Behaviour) -> None:
    """Put a node where another one is, in its parent's eyes."""
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
    """If what is done raises, take back the keys that it has declared, on this board and on those above."""
    chain = [board]
    while chain[-1].parent is not None:
        chain.append(chain[-1].parent)
    before = [{key for key, _ in one.entries()} for one in chain]
    try:
        yield
    except BaseException:  # also an interrupt must leave the boards as they were; it goes on
        for one, known in zip(chain, before, strict=True):
            for key in {key for key, _ in one.entries()} - known:
                one.unset(key)
        raise
