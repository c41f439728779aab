"""Writer of trees (from XML or from Python code) and of palettes for editors, in BehaviorTree.CPP's XML format."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import Enum
from typing import Any, get_args, get_origin

from py_trees import behaviours, composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...base.units import NONE, Dimension
from ..nodes import BUILTIN, CONDITIONS, Node, Port, SubTree
from ..nodes.port import ExactKey
from ..status import outcome_name
from .document import Document
from .element import Element, Source

WIDTH = 120
"""Maximum line width [characters]; an element that is longer is written with one attribute per line."""

_ESCAPES = {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;", "\t": "&#9;", "\r": "&#13;"}
_NOWHERE = Source("")


def element(tag: str, attributes: Mapping[str, str], children: Sequence[Element] = (), text: str = "") -> Element:
    """Create an element that was not read from a document."""
    made = Element(tag, _NOWHERE, 0)
    made.attributes = dict(attributes)
    made.children = list(children)
    made.text = text
    return made


def to_text(root: Element) -> str:
    """XML text of a document with this root element."""
    return "\n".join(['<?xml version="1.0" encoding="UTF-8"?>', *_lines(root), ""])


def escape(text: str) -> str:
    """Escape a text for use as the value of an attribute."""
    return "".join(_ESCAPES.get(c, c) for c in text)


def value_text(value: Any, dimension: Dimension | None = None) -> str:
    """Text of a Python value, as written to a file.

    Args:
        value: Text, which is returned unchanged; or a number, a bool, a status, an enum member, or a list of these.
        dimension: Dimension of numbers, which are in SI units; None or NONE for numbers without a unit.
    """
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Status):
        return outcome_name(value)
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, (list, tuple)):
        pairs = any(isinstance(item, (list, tuple)) for item in value)
        return ";".join(_point(item, dimension) if pairs else value_text(item, dimension) for item in value)
    unit = "" if dimension in (None, NONE) else f" {dimension}"
    return f"{value!r}{unit}"


def _point(point: Sequence[Any], dimension: Dimension | None) -> str:
    return ",".join(value_text(x, dimension) for x in point)


def _lines(root: Element) -> Iterator[str]:
    todo: list[tuple[Element | str, int]] = [(root, 0)]
    while todo:
        item, depth = todo.pop()
        indent = "  " * depth
        if isinstance(item, str):
            yield indent + item
            continue
        for comment in item.comments:
            yield f"{indent}<!--{comment}-->"
        opening = _opening(item, indent)
        if item.children:
            yield f"{opening}>"
            todo.append((f"</{item.tag}>", depth))
            todo += [(child, depth + 1) for child in reversed(item.children)]
        elif item.text:
            yield f"{opening}>{item.text.replace('&', '&amp;').replace('<', '&lt;').replace('>', '&gt;')}</{item.tag}>"
        else:
            yield f"{opening}/>"


def _opening(item: Element, indent: str) -> str:
    attributes = [f'{name}="{escape(value)}"' for name, value in item.attributes.items()]
    line = " ".join([f"{indent}<{item.tag}", *attributes])
    if len(line) <= WIDTH:
        return line
    return f"\n{indent}    ".join([f"{indent}<{item.tag}", *attributes])


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
    """Palette for an editor such as Groot2: a document that declares nodes and has no trees.

    Args:
        nodes: Node classes; Groot2 knows those of BehaviorTree.CPP itself, other editors do not.
    """
    models = [model_of(node) for node in _sorted(nodes)]
    return to_text(element("root", {"BTCPP_format": "4"}, [element("TreeNodesModel", {}, models)]))


def own_nodes(nodes: Iterable[type[Node]]) -> list[type[Node]]:
    """Node classes that are not part of BehaviorTree.CPP, sorted by kind and name, without duplicates."""
    return _sorted(n for n in nodes if n.tag not in BUILTIN or "navigation" in n.__module__)


def _sorted(nodes: Iterable[type[Node]]) -> list[type[Node]]:
    found = {n.tag: n for n in nodes if n.kind in _KINDS}
    return sorted(found.values(), key=lambda n: (_KINDS.index(n.kind), n.tag))


def model_of(node: type[Node]) -> Element:
    """Element that declares a node class in a TreeNodesModel."""
    return element(node.kind, {"ID": node.tag}, [_port(port) for port in node.ports.values()])


def type_name(port: Port) -> str:
    """Type of a port in a model: a unit for a quantity, else a C++ type."""
    if port.dimension not in (None, NONE):
        return str(port.dimension)
    kind = port.kind
    if get_origin(kind) is list:
        (item,) = get_args(kind)
        return f"std::vector<{_TYPES.get(item, 'std::string')}>"
    if isinstance(kind, type) and issubclass(kind, Enum) and kind is not Status:
        return kind.__name__
    return _TYPES.get(kind, "BT::AnyTypeAllowed")


def _port(port: Port) -> Element:
    attributes = {"name": port.name, "type": type_name(port)}
    if not port.required and port.default is not None:
        attributes["default"] = value_text(port.default, port.dimension)
    return element(port.direction.value, attributes, text=port.doc)


_NO_TAG = re.compile(r"^[^A-Za-z_\u0080-\U0010ffff]|[^\w.\-]|^(Action|Condition|Control|Decorator|SubTree)$")
MAIN = "MainTree"
"""Default ID of a tree."""


def write_tree(root: Behaviour, *, main: str = "", document: Document | None = None) -> str:
    """Write a tree as a document that BehaviorTree.CPP and Groot2 can read.

    Each subtree becomes a `<BehaviorTree>` of its own. Node classes that BehaviorTree.CPP does not have are declared in
    the TreeNodesModel. Attributes have a fixed order: ID, name, ports as declared by the class, conditions, others. A
    stock py_trees behaviour without a counterpart in BehaviorTree.CPP is written with the name of its class.

    Args:
        root: Root of the tree.
        main: ID of the written tree; by default that of the document's main tree, or `MainTree`.
        document: Document from which the tree was read; comments and models of subtrees are copied from it.
    """
    name = main or (document.main().name if document is not None else MAIN)
    return Writer(document).document(root, name)


class Writer:
    """Converter from nodes to the elements of a document.

    Args:
        document: Document from which the nodes were read, or None.
    """

    def __init__(self, document: Document | None) -> None:
        self.read = document
        self.trees: dict[str, Element] = {}
        self.written: dict[str, str] = {}
        self.classes: dict[str, type[Node]] = {}

    def document(self, root: Behaviour, main: str) -> str:
        self.trees[main] = element("BehaviorTree", {"ID": main})
        self.trees[main].children.append(self.tree(root))
        children = [*self.trees.values()]
        models = [*self.subtree_models(), *(model_of(node) for node in own_nodes(self.classes.values()))]
        if models:
            children.append(element("TreeNodesModel", {}, models))
        made = element("root", {"BTCPP_format": "4", "main_tree_to_execute": main}, children)
        if self.read is not None:
            made.comments = self.read.root.comments
            self.comment_trees(self.read)
        return to_text(made)

    def subtree_models(self) -> list[Element]:
        models = () if self.read is None else self.read.models.values()
        return [_copy(model.element) for model in models if model.kind == "SubTree" and model.name in self.trees]

    def comment_trees(self, document: Document) -> None:
        for name, tree in self.trees.items():
            if name in document.trees:
                read = document.trees[name].element
                tree.comments = read.comments
                tree.attributes |= {n: v for n, v in read.attributes.items() if n != "ID"}

    def tree(self, root: Behaviour) -> Element:
        """Element of a node with its descendants; subtrees are added to `trees`."""
        made: dict[Any, Element] = {}
        order, todo = [], [root]
        while todo:
            node = todo.pop()
            order.append(node)
            todo += node.children
        for node in reversed(order):  # children before their parents
            below = [made[child.id] for child in node.children]
            made[node.id] = self.subtree(node, below[0]) if isinstance(node, SubTree) else self.node(node, below)
        return made[root.id]

    def subtree(self, node: SubTree, body: Element) -> Element:
        """Element of a SubTree; the tree inside is added to `trees`, with a new ID if another tree has its ID."""
        text, name, count = to_text(body), node.tree, 1
        while self.written.get(name, text) != text or (name in self.trees and name not in self.written):
            count += 1
            name = f"{node.tree}_{count}"
        if name not in self.trees:
            self.trees[name] = element("BehaviorTree", {"ID": name}, [body])
            self.written[name] = text
        own = {"ID": name} | ({"name": node.name} if node.name != node.tree else {})
        own |= {"_autoremap": "true"} if node.autoremap else {}
        remaps = {n: value_text(v) for n, v in node.remaps.items() if not isinstance(v, ExactKey)}
        return self.element("SubTree", own | remaps | self.rest(node), node)

    def node(self, node: Behaviour, below: list[Element]) -> Element:
        tag, attributes = written(node)
        if isinstance(node, Node) and node.tag == tag:
            self.classes.setdefault(tag, type(node))
        rest = self.rest(node) if isinstance(node, Node) else {}
        name = {"name": node.name} if node.name != tag else {}
        made = self.element(tag, name | attributes | rest, node)
        if _NO_TAG.search(tag):  # the explicit form accepts any name
            made.tag, made.attributes = getattr(node, "kind", "Action"), {"ID": tag, **made.attributes}
        made.children = below
        return made

    def rest(self, node: Node) -> dict[str, str]:
        """Conditions of a node in their fixed order, then attributes of editors, which this package ignores."""
        conditions = {n: node.conditions[n].text for n in CONDITIONS if n in node.conditions}
        return conditions | {n: value_text(v) for n, v in node.other.items() if n != "_autoremap"}

    def element(self, tag: str, attributes: Mapping[str, str], node: Behaviour) -> Element:
        made = element(tag, attributes)
        if isinstance(node, Node) and isinstance(node.origin, Element):
            made.comments = node.origin.comments
        return made


def _copy(read: Element) -> Element:
    made = element(read.tag, read.attributes, [_copy(child) for child in read.children], read.text)
    made.comments = read.comments
    return made


def _given(node: Node) -> dict[str, str]:
    """Values that were given to a node's ports, as texts, in the order in which the class declares the ports."""
    given = {n: node.given[n] for n in node.ports if node.given.get(n) is not None}
    return {n: value_text(v, node.ports[n].dimension) for n, v in given.items()}


def written(node: Behaviour) -> tuple[str, dict[str, str]]:
    """Tag and attributes of a node in a document; the tag of an unknown py_trees behaviour is its class name."""
    if isinstance(node, Node):
        return node.written() or (node.tag, _given(node))
    for cls, tag in _STOCK.items():
        if type(node) is cls:
            return tag, _STOCK_PORTS.get(tag, lambda _: {})(node)
    if type(node) in (composites.Sequence, composites.Selector):
        reactive = "" if getattr(node, "memory", True) else "Reactive"
        return reactive + ("Sequence" if isinstance(node, composites.Sequence) else "Fallback"), {}
    return type(node).__name__, {}


_STOCK: dict[type, str] = {
    decorators.Inverter: "Inverter",
    decorators.FailureIsSuccess: "ForceSuccess",
    decorators.SuccessIsFailure: "ForceFailure",
    decorators.SuccessIsRunning: "KeepRunningUntilFailure",
    decorators.Repeat: "Repeat",
    decorators.Retry: "RetryUntilSuccessful",
    decorators.Timeout: "Timeout",
    behaviours.Success: "AlwaysSuccess",
    behaviours.Failure: "AlwaysFailure",
}
_STOCK_PORTS: Mapping[str, Any] = {
    "Repeat": lambda node: {"num_cycles": str(node.num_success)},
    "RetryUntilSuccessful": lambda node: {"num_attempts": str(node.num_failures)},
    "Timeout": lambda node: {"msec": str(round(node.duration * 1000))},
}
