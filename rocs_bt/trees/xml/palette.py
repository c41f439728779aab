"""The palette: a TreeNodesModel generated from the node classes, which an editor such as Groot2 offers nodes from."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum
from typing import Any, get_args, get_origin

from py_trees.common import Status

from ...units import NONE
from ..nodes import BUILTIN, REQUIRED, Node, Port
from .element import Element
from .text import element, to_text, value_text

_TYPES: dict[Any, str] = {
    bool: "bool",
    int: "int",
    float: "double",
    str: "std::string",
    Status: "BT::NodeStatus",
    Any: "BT::AnyTypeAllowed",
}
_KINDS = ("Action", "Condition", "Control", "Decorator")


def palette(nodes: Iterable[type[Node]]) -> str:
    """A document that holds no trees, only what an editor has to know of the nodes that BehaviorTree.CPP does not have.

    Args:
        nodes: The classes; BehaviorTree.CPP's own are left out, as editors know them.
    """
    models = [model_of(node) for node in own_nodes(nodes)]
    return to_text(element("root", {"BTCPP_format": "4"}, [element("TreeNodesModel", {}, models)]))


def own_nodes(nodes: Iterable[type[Node]]) -> list[type[Node]]:
    """The classes among these that an editor does not know, by kind and name, each once."""
    found = {n.tag: n for n in nodes if n.kind in _KINDS and (n.tag not in BUILTIN or "navigation" in n.__module__)}
    return sorted(found.values(), key=lambda n: (_KINDS.index(n.kind), n.tag))


def model_of(node: type[Node]) -> Element:
    """What a TreeNodesModel says of a node class."""
    return element(node.kind, {"ID": node.tag}, [_port(port) for port in node.ports.values()])


def type_name(port: Port[Any]) -> str:
    """How a model calls a port's type: a unit for a quantity, else a type of C++'s."""
    if port.dimension not in (None, NONE):
        return str(port.dimension)
    kind = port.kind
    if get_origin(kind) is list:
        (item,) = get_args(kind)
        return f"std::vector<{_TYPES.get(item, 'std::string')}>"
    if isinstance(kind, type) and issubclass(kind, Enum) and kind is not Status:
        return kind.__name__
    return _TYPES.get(kind, "BT::AnyTypeAllowed")


def _port(port: Port[Any]) -> Element:
    attributes = {"name": port.name, "type": type_name(port)}
    if port.default is not REQUIRED and port.default is not None:
        attributes["default"] = value_text(port.default, port.dimension)
    return element(port.direction.value, attributes, text=port.doc)
