"""Filters that select nodes of a tree (BehaviorTree.CPP 4.10, bt_factory.cpp, addSubstitutionRule)."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING, Any

from ...base.errors import Fault, InputError, did_you_mean
from ...plan import Act, ActionNode
from ...trees.nodes import Node, Tree

if TYPE_CHECKING:
    from ...trees import Behaviour


def identity(node: Behaviour) -> str:
    """Name of a node's class, as in tree documents (XML); for a leaf made by `mission.act`, the name of its action."""
    if isinstance(node, Act) and not isinstance(node, ActionNode):
        try:
            return node.make().name
        except InputError:  # already reported when the leaf was created
            return node.tag
    return node.tag if isinstance(node, Node) else type(node).__name__


def wild(text: str) -> bool:
    """Whether a filter contains a wildcard, `*` or `?`."""
    return "*" in text or "?" in text


class Filters:
    """Filters that select nodes of one tree.

    A filter may match a node in three ways, which take precedence in this order: the filter is the node's name or path;
    it is its `identity`; its wildcards match the path.
    """

    def __init__(self, root: Behaviour, filters: Iterable[str]) -> None:
        self._filters = list(filters)
        tree = Tree(root)
        self._paths = tree.paths()
        self._found = {node.id: tuple(dict.fromkeys(self._candidates(node))) for node in tree.nodes}

    def match(self, node: Behaviour, skip: Iterable[str] = ()) -> str | None:
        """Return the filter that takes precedence for a node; None if no filter matches it."""
        return next((text for text in self._found[node.id] if text not in skip), None)

    def refuse_unused(self) -> None:
        """Check that each filter matches a node.

        Raises:
            InputError: Some filters match no node; the error lists all of them.
        """
        used = {text for found in self._found.values() for text in found}
        if unused := [text for text in self._filters if text not in used]:
            there = sorted({*self._paths.values()})
            message = "'{}' matches no node of this tree."
            raise InputError(*(Fault(message.format(u), hint=did_you_mean(u, there, "It")) for u in unused))

    def _candidates(self, node: Any) -> Iterator[str]:
        path, plain = self._paths[node.id], [text for text in self._filters if not wild(text)]
        yield from (text for text in plain if text in (node.name, path))
        yield from (text for text in plain if text == identity(node))
        yield from (text for text in self._filters if wild(text) and _pattern(text).fullmatch(path))


@cache
def _pattern(text: str) -> re.Pattern[str]:
    parts = (".*" if letter == "*" else "." if letter == "?" else re.escape(letter) for letter in text)
    return re.compile("".join(parts), re.DOTALL)


def replace(parent: Any, old: Behaviour, new: Behaviour) -> None:
    """Replace a child in its parent node; for a root (parent None), only the new node's parent is set."""
    new.parent = parent
    if parent is not None:
        parent.children[next(i for i, child in enumerate(parent.children) if child is old)] = new
        if getattr(parent, "decorated", None) is old:
            parent.decorated = new
