"""From nodes back to XML: any tree, also one that was made in Python."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from py_trees import behaviours, composites, decorators
from py_trees.behaviour import Behaviour

from ..nodes import CONDITIONS, Node, SubTree
from ..nodes.port import ExactKey
from .document import Document
from .element import Element
from .palette import model_of, own_nodes
from .text import element, to_text, value_text

_NO_TAG = re.compile(r"^[^A-Za-z_\u0080-\U0010ffff]|[^\w.\-]|^(Action|Condition|Control|Decorator|SubTree)$")
MAIN = "MainTree"
"""The ID of a tree that has none."""


def write_tree(root: Behaviour, *, main: str = "", document: Document | None = None) -> str:
    """A tree as a document that BehaviorTree.CPP and Groot2 read.

    Each subtree becomes a tree of its own; nodes that BehaviorTree.CPP does not have are told in the TreeNodesModel.
    Attributes stand in a fixed order: ID, name, ports as the class declares them, conditions, then others. What of
    py_trees' own has no counterpart is written with its class's name.

    Args:
        root: The tree.
        main: Its ID; that of the document's main tree by default.
        document: What it was read from, whose models of subtrees are written too.
    """
    name = main or (document.main().name if document is not None else MAIN)
    return Writer(document).document(root, name)


class Writer:
    """Makes the elements of a document from nodes.

    Args:
        document: What they were read from, if anything.
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
                tree.attributes |= {n: v for n, v in read.attributes.items() if n.startswith("_")}

    def tree(self, root: Behaviour) -> Element:
        """The element of a node with all below it; its subtrees become trees."""
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
        """The element of a SubTree, whose body is a tree; another body under the same ID gets an ID of its own."""
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
        if _NO_TAG.search(tag):  # the long form takes any name
            made.tag, made.attributes = getattr(node, "kind", "Action"), {"ID": tag, **made.attributes}
        made.children = below
        return made

    def rest(self, node: Node) -> dict[str, str]:
        """Conditions, in their order, and what editors have left there."""
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
    """What a node's ports were given, in the order of its class."""
    given = {n: node.given[n] for n in node.ports if node.given.get(n) is not None}
    return {n: value_text(v, node.ports[n].dimension) for n, v in given.items()}


def written(node: Behaviour) -> tuple[str, dict[str, str]]:
    """Tag and attributes of a node in a document; what of py_trees' own has no counterpart keeps its class's name."""
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
