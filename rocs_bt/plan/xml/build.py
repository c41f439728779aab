"""From a document's elements to nodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from py_trees.behaviour import Behaviour

from ...errors import Fault, InputError
from ..nodes import Control, Decorator, Node, SubTree, children_faults
from .document import Document
from .element import Element
from .stand_in import stand_in
from .verify import MAX_NODES

Outside = Mapping[str, Callable[[Element], Behaviour]]
"""Trees that stand elsewhere by the ID that a SubTree names, made for that SubTree."""


@dataclass
class _Frame:
    """A node whose children are being made."""

    element: Element
    todo: list[Element]
    made: list[Behaviour] = field(default_factory=list)


def make_nodes(
    document: Document,
    nodes: Mapping[str, type[Node]],
    *,
    main: str = "",
    outside: Outside | None = None,
    lenient: bool = False,
) -> Behaviour:
    """The nodes of a document's main tree, each subtree made anew at each of its uses.

    The document must have passed `verify`, unless it is read leniently.

    Args:
        document: The document.
        nodes: The node classes that it may name.
        main: The ID of the tree; what the document says by default.
        outside: Trees that stand elsewhere.
        lenient: Whether stand-ins take the place of what is unknown or wrong.

    Returns:
        The root node. `origin` of each node is its element.

    Raises:
        InputError: A constructor refuses what stands there.
    """
    return _Maker(document, nodes, outside or {}, lenient).root(document.main(main).body)


class _Maker:
    def __init__(self, document: Document, nodes: Mapping[str, type[Node]], outside: Outside, lenient: bool) -> None:
        self.document = document
        self.nodes = nodes
        self.outside = outside
        self.lenient = lenient
        self.frames: list[_Frame] = []
        self.count = 0

    def root(self, body: Element) -> Behaviour:
        self.begin(body)
        while True:
            frame = self.frames[-1]
            if frame.todo:
                self.begin(frame.todo.pop())
                continue
            node = self.node(frame)
            self.frames.pop()
            if not self.frames:
                return node
            self.frames[-1].made.append(node)

    def begin(self, element: Element) -> None:
        self.count += 1
        if self.count > MAX_NODES:
            raise InputError(element.fault(f"the tree has more than {MAX_NODES} nodes."))
        name = element.attributes.get("ID", "")
        if element.tag != "SubTree":
            self.frames.append(_Frame(element, element.children[::-1]))
        elif name in self.document.trees and not self.inside(name):
            self.frames.append(_Frame(element, [self.document.trees[name].body]))
        else:
            self.frames.append(_Frame(element, [], self.elsewhere(element, name)))

    def inside(self, name: str) -> bool:
        """Whether a tree is being made already; told by `verify`, and so asked only where that was no obstacle."""
        return self.lenient and any(f.element.tag == "SubTree" and f.element.attributes["ID"] == name
                                    for f in self.frames if "ID" in f.element.attributes)  # fmt: skip

    def elsewhere(self, element: Element, name: str) -> list[Behaviour]:
        try:
            return [self.outside[name](element)] if name in self.outside or not self.lenient else []
        except InputError as error:
            raise InputError(*(_placed(element, fault) for fault in error.faults)) from error

    def node(self, frame: _Frame) -> Node:
        element = frame.element
        attributes = element.node_attributes()
        made = self.made(frame)
        if issubclass(made, SubTree):
            attributes = {**self.defaults(element), **attributes}
        family: Callable[..., Node] = made
        try:
            if issubclass(made, (Control, Decorator)):
                node = family(element.node_name, frame.made, **attributes)
            else:
                node = family(element.node_name, **attributes)
        except InputError as error:
            raise InputError(*(_placed(element, fault) for fault in error.faults)) from error
        node.origin = element
        return node

    def made(self, frame: _Frame) -> type[Node]:
        """The class of an element."""
        element = frame.element
        found = self.nodes.get(element.node_tag)
        if not self.lenient:
            return self.nodes[element.node_tag]
        if found is None or children_faults(found, "", len(frame.made)):
            return stand_in(element, self.document)
        faults = found.attribute_faults(element.node_attributes())
        if issubclass(found, SubTree) and element.attributes.get("_autoremap", "0").lower() not in _TRUTH:
            faults.append(("_autoremap", Fault("")))
        return stand_in(element, self.document) if faults else found

    def defaults(self, element: Element) -> dict[str, str]:
        """What a subtree's model gives for the ports that its user leaves out."""
        model = self.document.models.get(element.attributes["ID"])
        if model is None or model.kind != "SubTree":
            return {}
        ports = model.ports.values()
        return {p.name: p.default for p in ports if p.default is not None and p.name not in element.attributes}


_TRUTH = ("true", "false", "1", "0")


def _placed(element: Element, fault: Fault) -> Fault:
    return fault if fault.file is not None or fault.line else element.fault(fault.message, fault.hint)
