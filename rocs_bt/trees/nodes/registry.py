"""Registry: the node classes that a document may name; BUILTIN has those that every document may."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import ModuleType
from typing import Any, Final

from py_trees.behaviour import Behaviour

from ...errors import Fault, InputError, unknown
from . import actions, decorators
from .control import branch, navigation, ordered, parallel
from .node import Node
from .subtree import SubTree


class Registry(Mapping[str, type[Node]]):
    """Node classes by the name that files call them.

    A class is found by being in a module that is given here; it registers nowhere. Its name is `tag`, or the class's.

    Args:
        classes: The classes.

    Raises:
        InputError: Two classes have one name.
    """

    def __init__(self, classes: Iterable[type[Node]] = ()) -> None:
        self._classes: dict[str, type[Node]] = {}
        for node in classes:
            other = self._classes.setdefault(node.tag, node)
            if other is not node:
                raise InputError(Fault(f"two nodes are named '{node.tag}': {_origin(other)} and {_origin(node)}."))

    def __getitem__(self, tag: str) -> type[Node]:
        return self._classes[tag]

    def __iter__(self) -> Iterator[str]:
        return iter(self._classes)

    def __len__(self) -> int:
        return len(self._classes)

    def with_(self, classes: Iterable[type[Node]]) -> Registry:
        """This registry and some more classes."""
        return Registry([*self._classes.values(), *classes])

    def find(self, tag: str) -> type[Node]:
        """The class of a name.

        Raises:
            InputError: There is none; the closest names are told.
        """
        if tag not in self._classes:
            raise InputError(unknown("node", tag, self._classes))
        return self._classes[tag]

    def make(self, tag: str, name: str, children: Sequence[Behaviour], attributes: Mapping[str, Any]) -> Node:
        """A node as a document describes it.

        Args:
            tag: Its class's name.
            name: Its own.
            children: Its children, made before.
            attributes: Its ports, conditions and what else stands there, without `ID` and `name`.

        Raises:
            InputError: No such class, the wrong number of children, or faulty attributes: all that is wrong.
        """
        node = self.find(tag)
        faults = [*children_faults(node, name, len(children)), *(f for _, f in node.attribute_faults(attributes))]
        if faults:
            raise InputError(*faults)
        made: Any = node  # leaves take no children; the two other families take theirs second
        found: Node = made(name, children, **attributes) if node.min_children else made(name, **attributes)
        return found


def children_faults(node: type[Node], name: str, count: int) -> list[Fault]:
    """Why a node class cannot have that many children; empty when it can."""
    least, most = node.min_children, node.max_children
    if count >= least and (most is None or count <= most):
        return []
    wanted = f"{least}" if least == most else f"at least {least}" if most is None else f"{least} to {most}"
    return [Fault(f"'{name}' ({node.tag}) needs {wanted if most != 0 else 'no'} children, found {count}.")]


def nodes_of(module: ModuleType) -> list[type[Node]]:
    """The node classes that a module defines itself and that can be made, in the order of their names."""
    found = [v for v in vars(module).values() if isinstance(v, type) and issubclass(v, Node)]
    return sorted(
        (n for n in found if n.__module__ == module.__name__ and not inspect.isabstract(n) and not _base(n)),
        key=lambda node: node.tag,
    )


def _base(node: type[Node]) -> bool:
    return node.__name__.startswith("_") or node.tick_once is Node.tick_once


def _origin(node: type[Node]) -> str:
    return f"{node.__module__}.{node.__qualname__}"


_MODULES = (actions, branch, navigation, ordered, parallel, decorators)
BUILTIN: Final = Registry([*(node for module in _MODULES for node in nodes_of(module)), SubTree])
"""BehaviorTree.CPP 4.10's own nodes, and the control nodes of Nav2."""
