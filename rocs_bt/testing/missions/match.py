"""Which nodes of a tree a filter means (BehaviorTree.CPP 4.10, bt_factory.cpp, addSubstitutionRule)."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING, Any

from ...errors import Fault, InputError, did_you_mean
from ...plan import Act, ActionNode
from ...trees.nodes import Node, Tree

if TYPE_CHECKING:
    from ...trees import Behaviour


def identity(node: Behaviour) -> str:
    """By which name documents call a node's class; of a leaf that `mission.act` made, its action's."""
    if isinstance(node, Act) and not isinstance(node, ActionNode):
        try:
            return node.make().name
        except InputError:  # told where it was made
            return node.tag
    return node.tag if isinstance(node, Node) else type(node).__name__


def wild(text: str) -> bool:
    """Whether a filter has wildcards."""
    return "*" in text or "?" in text


class Filters:
    """Filters over the nodes of one tree: names, then identities, then wildcards over paths, in the order given.

    Args:
        root: The tree's root.
        filters: The filters.
    """

    def __init__(self, root: Behaviour, filters: Iterable[str]) -> None:
        self._filters = list(filters)
        tree = Tree(root)
        self._paths = tree.paths()
        self._found = {node.id: tuple(dict.fromkeys(self._candidates(node))) for node in tree.nodes}

    def match(self, node: Behaviour, skip: Iterable[str] = ()) -> str | None:
        """The filter that means a node; None where none does.

        Args:
            node: The node.
            skip: Filters that are not asked.
        """
        return next((text for text in self._found[node.id] if text not in skip), None)

    def refuse_unused(self) -> None:
        """Refuse filters that mean no node.

        Raises:
            InputError: There are some; every one of them is told.
        """
        used = {text for found in self._found.values() for text in found}
        if unused := [text for text in self._filters if text not in used]:
            there = sorted({*self._paths.values()})
            message = "'{}' means no node of this tree."
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
    """Put a node in another's place under its parent; None is the parent of a root."""
    new.parent = parent
    if parent is not None:
        parent.children[next(i for i, child in enumerate(parent.children) if child is old)] = new
        if getattr(parent, "decorated", None) is old:
            parent.decorated = new
