"""Registry of node classes by name; BUILTIN is the registry of the classes that every tree file may use."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import ModuleType
from typing import Any, Final

from py_trees.behaviour import Behaviour

from ...base.errors import Fault, InputError, unknown
from . import actions, decorators
from .control import branch, navigation, ordered, parallel
from .node import Node
from .subtree import SubTree


class Registry(Mapping[str, type[Node]]):
    """Node classes by their name in files.

    The name of a class is its attribute `tag`, by default the class name. Defining a class does not register it: a
    registry contains only the classes that it is given.

    Raises:
        InputError: Two classes have the same name.
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
        """Return a registry with additional classes."""
        return Registry([*self._classes.values(), *classes])

    def replaced(self, classes: Iterable[type[Node]]) -> Registry:
        """Return a registry in which these classes replace those of the same name, or are added."""
        return Registry({**self._classes, **{node.tag: node for node in classes}}.values())

    def find(self, tag: str) -> type[Node]:
        """Find the node class with a name.

        Raises:
            InputError: No class has this name; the hint lists the closest names.
        """
        if tag not in self._classes:
            raise InputError(unknown("node", tag, self._classes))
        return self._classes[tag]

    def make(self, tag: str, name: str, children: Sequence[Behaviour], attributes: Mapping[str, Any]) -> Node:
        """Create a node from its description in a document.

        Args:
            tag: Name of the class.
            name: Name of the node.
            children: Child nodes, already created.
            attributes: Ports, conditions and other attributes, without `ID` and `name`.

        Raises:
            InputError: All faults: unknown class, wrong number of children, faulty attributes.
        """
        node = self.find(tag)
        faults = [*children_faults(node, name, len(children)), *(f for _, f in node.attribute_faults(attributes))]
        if faults:
            raise InputError(*faults)
        made: Any = node  # leaves take no children; the two other families take theirs second
        found: Node = made(name, children, **attributes) if node.min_children else made(name, **attributes)
        return found


def children_faults(node: type[Node], name: str, count: int) -> list[Fault]:
    """Faults of a node with a wrong number of children; empty if its class allows the number."""
    least, most = node.min_children, node.max_children
    if count >= least and (most is None or count <= most):
        return []
    wanted = f"{least}" if least == most else f"at least {least}" if most is None else f"{least} to {most}"
    return [Fault(f"'{name}' ({node.tag}) needs {wanted if most != 0 else 'no'} children, found {count}.")]


def nodes_of(module: ModuleType) -> list[type[Node]]:
    """Concrete node classes that a module defines, sorted by name."""
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
"""The nodes of BehaviorTree.CPP 4.10 and the control nodes of Nav2."""
