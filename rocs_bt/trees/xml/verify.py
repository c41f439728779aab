"""Checks of a document before nodes are created: names, ports, scripts, subtrees. All faults are reported at once."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from ...base.errors import Fault, InputError, NameHint, did_you_mean, unknown
from ...base.nesting import descendants
from ..nodes import CONDITIONS, Node, children_faults
from ..script import ScriptError, parse_script
from ..value import from_string
from .document import Document, TreeElement
from .element import EXPLICIT, Element
from .model import differs
from .version_3 import convert_outputs

FORBIDDEN = re.compile(r"""[ \t\r\n<>&"'/\\:*?|.\x00-\x1f\x7f]""")


def name_faults(document: Document, strict: bool) -> Iterator[Fault]:
    """Faults of IDs and port names that Groot2 or BehaviorTree.CPP 4.10 rejects.

    They are errors if `strict`, else warnings.
    """
    for tree in document.trees.values():
        if "ID" in tree.element.attributes:
            yield from _faults("tree", tree.name, tree.element, "ID", strict)
    for model in document.models.values():
        yield from _faults("node", model.name, model.element, "ID", strict)
        for port in model.ports.values():
            yield from _faults("port", port.name, port.element, "name", strict)


def _faults(what: str, name: str, element: Element, attribute: str, strict: bool) -> Iterator[Fault]:
    found = FORBIDDEN.search(name)
    message = f"the {what} name '{name}' contains {found[0]!r}." if found else ""
    if what == "tree" and name in ("Root", "root"):
        message = f"a tree must not be named '{name}'."
    if what == "port" and not message and not name[:1].isalpha():
        message = f"the port name '{name}' does not begin with a letter."
    if message:
        hint = "BehaviorTree.CPP 4.10 rejects it; use letters, digits, '_' and '-'."
        yield element.fault(message, hint, attribute=attribute, warning=not strict)


_NOWHERE: Mapping[str, tuple[str, str]] = MappingProxyType({})

MAX_NODES = 65_535
"""Maximum number of nodes of a tree, with those of its subtrees; BehaviorTree.CPP numbers nodes with 16 bits."""


def verify(
    document: Document,
    nodes: Mapping[str, type[Node]],
    *,
    main: str = "",
    outside: Mapping[str, Any] | None = None,
    strict: bool = False,
    elsewhere: Mapping[str, tuple[str, str]] = _NOWHERE,
) -> list[Fault]:
    """Errors and warnings of a document's trees, in addition to `document.faults`.

    Completes the conversion of a document of version 3, which needs the ports of the nodes.

    Args:
        document: Document to check.
        nodes: Node classes that the document may use, by name.
        main: ID of the tree to tick; by default the document's main tree.
        outside: Trees that are not in the document but that a SubTree may use, by ID.
        strict: Whether names that BehaviorTree.CPP 4.10 rejects are errors instead of warnings.
        elsewhere: Message and hint for each unknown node that exists in another dialect, by the node's name.
    """
    for root in document.version_3:
        convert_outputs(root, nodes, document.models)
    return _Verifier(document, nodes, outside or {}, elsewhere).faults(main, strict)


class _Verifier:
    def __init__(
        self,
        document: Document,
        nodes: Mapping[str, type[Node]],
        outside: Mapping[str, Any],
        elsewhere: Mapping[str, tuple[str, str]],
    ) -> None:
        self.elsewhere = elsewhere
        self.document = document
        self.nodes = dict(nodes)
        self.outside = outside
        self.found: list[Fault] = []
        self.uses: dict[str, list[Element]] = {}
        self.counts: dict[str, int] = {}
        self.others: set[str] = set()

    def faults(self, main: str, strict: bool) -> list[Fault]:
        self.found += name_faults(self.document, strict)
        for tree in self.document.trees.values():
            if tree.name in self.nodes:
                message = f"the tree '{tree.name}' has the name of a node."
                self.found.append(tree.element.fault(message, "Rename the tree.", attribute="ID"))
            self.uses[tree.name] = []
            self.elements(tree)
            self.defaults(tree)
            self.found += _equal_names(tree, self.uses[tree.name], strict)
        self.models()
        self.recursion()
        self.unused(main)
        return self.found

    def elements(self, tree: TreeElement) -> None:
        """Check all elements of a tree, in the order of the document."""
        stack: list[tuple[_Ancestors | None, Iterator[Element]]] = [(None, iter([tree.body]))]
        count = 0
        while stack:
            ancestors, elements = stack[-1]
            for element in elements:
                count += 1
                if not self.plain(element):
                    self.element(element, _path(tree, element, ancestors), tree)
                if element.children:
                    stack.append((_Ancestors(element, ancestors), iter(element.children)))
                    break
            else:
                stack.pop()
        self.counts[tree.name] = count

    def plain(self, element: Element) -> bool:
        """Whether an element in the short form `<GoTo/>` has no faults. This quick test covers most elements."""
        node = self.nodes.get(element.tag)
        if node is None or element.tag == "SubTree" or "ID" in element.attributes:
            return False
        count, most = len(element.children), node.max_children
        if count < node.min_children or (most is not None and count > most):
            return False
        return not node.attribute_faults(element.node_attributes())

    def element(self, element: Element, path: str, tree: TreeElement) -> None:
        tag = element.node_tag
        if element.tag == "SubTree":
            self.subtree(element, path, tree)
        elif element.tag in EXPLICIT and not tag:
            self.found.append(element.fault(f"<{element.tag}> has no ID of a node.", 'Write ID="Name".', path=path))
            return
        elif "ID" in element.attributes and element.tag not in EXPLICIT:
            hint = f'Write <{element.tag} name="..."/>, or <Action ID="{element.tag}"/>.'
            message = f"<{element.tag}> is named by its tag but also has an ID."
            self.found.append(element.fault(message, hint, attribute="ID", path=path))
        node = self.nodes.get(tag)
        if node is None:
            self.found.append(self.unknown_node(element, tag, path))
            return
        if element.tag != "SubTree":
            for fault in children_faults(node, element.node_name, len(element.children)):
                self.found.append(element.fault(fault.message, fault.hint, path=path))
        faults = node.attribute_faults(element.node_attributes())
        if faults and (model := self.document.models.get(tag)) is not None and differs(model, node):
            self.other_node(element, tag, path)
            return
        for attribute, fault in faults:
            column = _script_column(node, attribute, element.attributes.get(attribute, ""))
            self.found.append(element.fault(fault.message, fault.hint, attribute=attribute, column=column, path=path))

    def other_node(self, element: Element, tag: str, path: str) -> None:
        """Add one error for all elements of a node with a model that differs from the class of the same name."""
        if tag not in self.others:
            self.others.add(tag)
            message = f"the class {tag} has other ports than the node '{tag}' that the TreeNodesModel declares."
            hint = f"{_port_list(self.nodes[tag])} Rename the node; or use --stub-unknown, which uses the model."
            self.found.append(element.fault(message, hint, path=path))

    def unknown_node(self, element: Element, tag: str, path: str) -> Fault:
        attribute = "ID" if element.tag in EXPLICIT else ""
        if tag in self.document.trees:
            hint = f'It is a tree: write <SubTree ID="{tag}"/>.'
            return element.fault(f"no node is named '{tag}'.", hint, attribute=attribute, path=path)
        if tag in self.document.models:
            hint = "Write it as a class in planners/nodes; or check the file with --stub-unknown, which uses the model."
            message = f"the node '{tag}' has a model in the TreeNodesModel but no class."
            return element.fault(message, hint, attribute=attribute, path=path)
        if tag in self.elsewhere:
            return element.fault(*self.elsewhere[tag], attribute=attribute, path=path)
        fault = unknown("node", tag, self.nodes)
        hint = _extended(fault.hint, "For nodes of another robot use --palette FILE or --stub-unknown.")
        return element.fault(fault.message, hint, attribute=attribute, path=path)

    def subtree(self, element: Element, path: str, tree: TreeElement) -> None:
        name = element.attributes.get("ID", "")
        if not name:
            self.found.append(element.fault("the SubTree has no ID of a tree.", 'Write ID="Name".', path=path))
            return
        if element.children:
            hint = f'Move them into <BehaviorTree ID="{name}">.'
            self.found.append(element.fault("a SubTree must not have children.", hint, path=path))
        if name in self.document.trees:
            self.uses[tree.name].append(element)
        elif name not in self.outside:
            fault = unknown("tree", name, {*self.document.trees, *self.outside}, "The document")
            hint = _extended(fault.hint, "Check it together with the file that holds the tree, or with --stub-unknown.")
            self.found.append(element.fault(fault.message, hint, attribute="ID", path=path))
        given, model = element.attributes, self.document.models.get(name)
        try:
            remapped = from_string(given.get("_autoremap", "false"), bool)
        except InputError as error:
            self.found += (element.fault(f.message, attribute="_autoremap", path=path) for f in error.faults)
            return
        if model is None or model.kind != "SubTree" or remapped:
            return
        defaults = self.document.trees[name].defaults if name in self.document.trees else {}
        for port in model.ports.values():
            if port.name not in given and port.name not in defaults and not port.default:
                hint = f'Write {port.name}="{{key}}" or a value, or give the port a default in the TreeNodesModel.'
                self.found.append(element.fault(f"the subtree '{name}' needs '{port.name}'.", hint, path=path))

    def defaults(self, tree: TreeElement) -> None:
        """Add warnings about attributes of `<BehaviorTree>` that are no keys of the tree."""
        if not tree.defaults:
            return
        texts = (text for e in descendants(tree.body) for item in e.attributes.items() for text in item)
        words = {word for text in texts for word in re.findall(r"\w+", text)}
        for name in sorted(tree.defaults.keys() - words):
            message = f"no node of the tree '{tree.name}' uses the key '{name}'."
            hint = "Attributes of <BehaviorTree> are defaults of the tree's keys."
            self.found.append(tree.element.fault(message, hint, attribute=name, warning=True))

    def models(self) -> None:
        """Add warnings about models that declare ports which the node class does not have, or no longer has."""
        for model in self.document.models.values():
            node = self.nodes.get(model.name)
            if model.kind == "SubTree" or node is None:
                continue
            for port in model.ports.values():
                if port.name not in node.ports:
                    fault = unknown("port", port.name, node.ports, model.name)
                    message = f"the class {model.name} has no port '{port.name}'; the model is outdated."
                    self.found.append(port.element.fault(message, fault.hint, warning=True))

    def recursion(self) -> None:
        """Add faults of trees that contain themselves or that exceed the maximum size."""
        sizes: dict[str, int] = {}
        for start in self.uses:
            ancestors = {start: iter(self.uses[start])}  # in order; a dictionary, so that a search takes no time
            while ancestors:
                name, uses = next(reversed(ancestors.items()))
                use = next((u for u in uses if u.attributes["ID"] not in sizes), None)
                if use is None:
                    sizes[name] = self.size(name, sizes)
                    del ancestors[name]
                    continue
                below = use.attributes["ID"]
                if below in ancestors:
                    names = list(ancestors)
                    chain = " -> ".join([*names[names.index(below) :], below])
                    message = f"the tree '{below}' contains itself: {chain}."
                    self.found.append(use.fault(message, "Use a Repeat, or remove one SubTree.", attribute="ID"))
                    sizes[below] = 1
                else:
                    ancestors[below] = iter(self.uses[below])

    def size(self, name: str, sizes: Mapping[str, int]) -> int:
        tree = self.document.trees[name]
        total = self.counts[name] + sum(sizes.get(u.attributes["ID"], 0) for u in self.uses[name])
        if total > MAX_NODES:
            message = f"the tree '{name}' has {total} nodes including its subtrees; the maximum is {MAX_NODES}."
            self.found.append(tree.element.fault(message))
            return 1  # counted as 1, so that the enclosing trees are not reported, too
        return total

    def unused(self, main: str) -> None:
        """Add warnings about trees that are not in an included file and that the main tree does not use."""
        start = main or self.document.named
        if start not in self.uses or self.document.library:
            return
        reached, todo = {start}, [start]
        while todo:
            names = {u.attributes["ID"] for u in self.uses[todo.pop()]} - reached
            reached |= names
            todo += names
        for tree in self.document.trees.values():
            if tree.name not in reached and not tree.included:
                message = f"the tree '{tree.name}' is not used."
                hint = f'Use it by <SubTree ID="{tree.name}"/>, or remove it.'
                self.found.append(tree.element.fault(message, hint, attribute="ID", warning=True))


def _equal_names(tree: TreeElement, uses: list[Element], strict: bool) -> Iterator[Fault]:
    """Faults of SubTrees in one tree that have the same `name`."""
    names: set[str] = set()
    for use in uses:
        name = use.attributes.get("name", "")
        if name and name in names:
            hint = "BehaviorTree.CPP 4.10 rejects it; rename one of them."
            message = f"two SubTrees of the tree '{tree.name}' are named '{name}'."
            yield use.fault(message, hint, attribute="name", warning=not strict)
        names.add(name)


def _port_list(node: type[Node]) -> str:
    return did_you_mean("", node.ports, node.tag) if node.ports else f"{node.tag} has no ports."


def _extended(hint: str, other: str) -> str:
    """Append another remedy to a hint, unless the hint already suggests a similar name."""
    if isinstance(hint, NameHint):
        return hint if hint.close else hint.and_also(other)
    return f"{hint} {other}"


class _Ancestors(NamedTuple):
    """Linked list of the elements that enclose an element, the innermost first."""

    element: Element
    above: _Ancestors | None


def _path(tree: TreeElement, element: Element, ancestors: _Ancestors | None) -> str:
    """Path of a node: the ID of its tree, then the names of its ancestors, then its own name."""
    names = [element.node_name]
    while ancestors is not None:
        names.append(ancestors.element.node_name)
        ancestors = ancestors.above
    return "/".join([tree.name, *reversed(names)])


def _script_column(node: type[Node], attribute: str, text: str) -> int | None:
    """Position of a script error in an attribute's value, counted from 0; None if there is no script error."""
    try:
        if attribute in CONDITIONS:
            parse_script(text)
        elif attribute in node.ports:
            node.ports[attribute].value(text)
    except ScriptError as error:
        return error.column
    except InputError:
        pass
    return None
