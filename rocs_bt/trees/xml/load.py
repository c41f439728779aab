"""Creation of nodes from the elements of a document; `load_xml` reads, checks and builds a tree in one call."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from pathlib import Path

from py_trees.behaviour import Behaviour

from ...base.errors import Fault, InputError
from ..error import TreeWarning
from ..nodes import BUILTIN, Node, children_faults, pointer
from ..nodes.port import ExactKey
from ..nodes.subtree import literal
from .document import Document, read_document
from .element import Element
from .model import OWN_NAME
from .stub import lenient_stub
from .verify import MAX_NODES, verify

Outside = Mapping[str, Callable[[Element], Behaviour]]
"""Trees that are not in the document: for each tree ID, a function from the SubTree element to the tree's root."""


class _Frame:
    """Entry of the stack of enclosing nodes: a node during the creation of its children."""

    __slots__ = ("element", "made", "todo")

    def __init__(self, element: Element, todo: list[Element], made: list[Behaviour] | None = None) -> None:
        self.element = element
        self.todo = todo  # not yet created, in reverse order
        self.made: list[Behaviour] = [] if made is None else made


def make_nodes(
    document: Document,
    nodes: Mapping[str, type[Node]],
    *,
    main: str = "",
    outside: Outside | None = None,
    lenient: bool = False,
) -> Node:
    """Create the nodes of a document's main tree; each use of a subtree gets its own nodes.

    The document must have passed `verify`, unless `lenient` is true.

    Args:
        document: Document with the tree.
        nodes: Node classes that the document may use, by name.
        main: ID of the tree to create; by default the document's main tree.
        outside: Trees that are not in the document.
        lenient: Whether stubs replace unknown or faulty nodes.

    Returns:
        Root node, with the tree's defaults as `initial_keys`. The attribute `origin` of each node is its element.

    Raises:
        InputError: A node's constructor rejects its attributes.
    """
    tree = document.main(main)
    root = _Maker(document, nodes, outside or {}, lenient).root(tree.body)
    root.initial_keys = {n: literal(v) for n, v in tree.defaults.items() if pointer(v) is None}
    return root


class _Maker:
    def __init__(self, document: Document, nodes: Mapping[str, type[Node]], outside: Outside, lenient: bool) -> None:
        self.document = document
        self.nodes = dict(nodes)
        self.outside = outside
        self.lenient = lenient
        self.frames: list[_Frame] = []
        self.count = 1

    def root(self, body: Element) -> Node:
        frames = self.frames
        frames.append(self.begin(body))
        while True:
            frame = frames[-1]
            while frame.todo:
                element = frame.todo.pop()
                self.count += 1
                if self.count > MAX_NODES:
                    raise InputError(element.fault(f"the tree has more than {MAX_NODES} nodes."))
                if element.children or element.tag == "SubTree":
                    frame = self.begin(element)
                    frames.append(frame)
                else:
                    frame.made.append(self.node(element, []))
            node = self.node(frame.element, frame.made)
            frames.pop()
            if not frames:
                return node
            frames[-1].made.append(node)

    def begin(self, element: Element) -> _Frame:
        name = element.attributes.get("ID", "")
        if element.tag != "SubTree":
            return _Frame(element, element.children[::-1])
        if name in self.document.trees and not self.inside(name):
            return _Frame(element, [self.document.trees[name].body])
        return _Frame(element, [], self.elsewhere(element, name))

    def inside(self, name: str) -> bool:
        """Whether a tree would contain itself. Only lenient mode needs this: otherwise `verify` rejects recursion."""
        return self.lenient and any(
            f.element.tag == "SubTree" and f.element.attributes["ID"] == name
            for f in self.frames
            if "ID" in f.element.attributes
        )

    def elsewhere(self, element: Element, name: str) -> list[Behaviour]:
        try:
            return [self.outside[name](element)] if name in self.outside or not self.lenient else []
        except InputError as error:
            raise InputError(*(_placed(element, fault) for fault in error.faults)) from error

    def node(self, element: Element, children: list[Behaviour]) -> Node:
        attributes = element.node_attributes()
        made = self.made(element, children)
        if made.kind == "SubTree":
            attributes = {**self.defaults(element), **attributes}
        family: Callable[..., Node] = made
        try:
            if made.max_children != 0:
                node = family(element.node_name, children, **attributes)
            else:
                node = family(element.node_name, **attributes)
        except InputError as error:
            raise InputError(*(_placed(element, fault) for fault in error.faults)) from error
        node.origin = element
        return node

    def made(self, element: Element, children: list[Behaviour]) -> type[Node]:
        """Class of an element's node; in lenient mode, a stub class if the class is unknown or rejects the element."""
        if not self.lenient:
            return self.nodes[element.node_tag]
        found = self.nodes.get(element.node_tag)
        if found is None or children_faults(found, "", len(children)):
            return lenient_stub(element, self.document)
        faults = found.attribute_faults(element.node_attributes())
        if element.tag == "SubTree" and element.attributes.get("_autoremap", "0").lower() not in _TRUTH:
            faults.append(("_autoremap", Fault("")))
        return lenient_stub(element, self.document) if faults else found

    def defaults(self, element: Element) -> dict[str, str]:
        """Defaults that a subtree or its model declares, for the ports that a SubTree element omits."""
        name = element.attributes["ID"]
        if element.attributes.get("_autoremap", "false").lower() in ("true", "1"):
            return {}  # as in BehaviorTree.CPP, a key that is not remapped refers to the parent's key
        model, found = self.document.models.get(name), dict[str, str]()
        if model is not None and model.kind == "SubTree":
            ports = [p for p in model.ports.values() if p.default]
            found = {p.name: ExactKey("=") if p.default == OWN_NAME else str(p.default) for p in ports}
        tree = self.document.trees.get(name)
        return found if tree is None else {**found, **tree.defaults}


_TRUTH = ("true", "false", "1", "0")


def _placed(element: Element, fault: Fault) -> Fault:
    return fault if fault.file is not None or fault.line else element.fault(fault.message, fault.hint)


def load_xml(
    source: Path | str,
    nodes: Mapping[str, type[Node]] = BUILTIN,
    *,
    main: str = "",
    within: Path | None = None,
    strict: bool = False,
) -> Behaviour:
    """Load the main tree of a document in BehaviorTree.CPP's XML format, version 4 (or 3, which is converted).

        root = load_xml(Path("patrol.xml"))
        tree = Tree(root, clock=clock)

    Args:
        source: Path of a file, or text of a document.
        nodes: Node classes that the document may use, by name.
        main: ID of the tree to load; by default the tree that `main_tree_to_execute` names, or the only one.
        within: Folder in which included files must lie; by default the folder of the file.
        strict: Whether names that BehaviorTree.CPP 4.10 rejects are errors instead of warnings.

    Returns:
        Root node, to be bound by a `Tree`.

    Warns:
        TreeWarning: The document contains what is probably a mistake, such as a second tree of one name.

    Raises:
        InputError: The document has errors; the exception lists all of them, each with its line and column.
    """
    document = read_document(source, within=within)
    faults = [*document.faults, *verify(document, nodes, main=main, strict=strict)]
    try:
        document.main(main)
    except InputError as error:
        faults += error.faults
    if wrong := [fault for fault in faults if not fault.warning]:
        raise InputError(*wrong)
    for fault in faults:
        warnings.warn(str(fault), TreeWarning, stacklevel=2)
    return make_nodes(document, nodes, main=main)
