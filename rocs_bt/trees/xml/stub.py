"""Stub classes for nodes without an available class, so that any tree can be drawn and checked."""

from __future__ import annotations

import contextlib
import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from ...base.errors import Fault, InputError
from ...declare import Field
from ..nodes import BUILTIN, CONDITIONS, Direction, Leaf, Node, port_of
from ..script import ScriptError, parse_script
from ..status import SUCCESS, Outcome
from .document import Document
from .element import Element
from .model import Model, ModelPort, annotation, differs

_Sequence: Any = BUILTIN["Sequence"]


class _AcceptsAll(Node):
    """Base class of stubs that accept any attribute."""

    @classmethod
    def attribute_faults(cls, attributes: Mapping[str, Any]) -> list[tuple[str, Fault]]:
        return []

    def _prepare(self, attributes: Mapping[str, Any]) -> None:
        super()._prepare({n: v for n, v in attributes.items() if not _broken(n, v)})


class LenientStub(_AcceptsAll, Leaf):
    """Returns SUCCESS. Its ports are those of its model and of its element; they accept any value."""

    def update(self) -> Outcome:
        return SUCCESS


class LenientStubWithChildren(_AcceptsAll, _Sequence):  # type: ignore[misc]  # a class that the registry found
    """Lenient stub with children; returns the outcome of a Sequence of them."""


def lenient_stub(element: Element, document: Document) -> type[Node]:
    """Create a stub class for an element with a node class that is unknown or rejects the element."""
    tag = element.attributes.get("ID", "") if element.tag == "SubTree" else element.node_tag
    model = document.models.get(tag)
    ports: dict[str, Field] = {}
    for each in model.ports.values() if model is not None else ():
        ports[each.name] = port_of(Any, each.direction, each.doc, default=each.default, name=each.name)
    for name in _ports_given(element):
        if name not in ports:
            ports[name] = port_of(Any, Direction.INOUT, default=None, name=name)
    base = LenientStubWithChildren if element.children else LenientStub
    kind = "Control" if len(element.children) > 1 else "Decorator" if element.children else "Action"
    members = {f"port {name}": port for name, port in ports.items()}  # no identifier, so no clash with attributes
    return type(tag or "Unnamed", (base,), {**members, "tag": tag or "Unnamed", "kind": kind, "__module__": __name__})


class Stub(Leaf):
    """Returns SUCCESS. A node that a palette declares; its ports are checked against the declaration."""

    def update(self) -> Outcome:
        return SUCCESS


class StubWithChildren(_Sequence):  # type: ignore[misc]  # a class that the registry found
    """Stub with children; returns the outcome of a Sequence of them."""


def stub_nodes(
    document: Document,
    known: Mapping[str, type[Node]],
    models: Mapping[str, Model],
    *,
    undeclared: bool,
    everywhere: Mapping[str, Sequence[Element]] = MappingProxyType({}),
) -> tuple[list[type[Node]], list[Fault]]:
    """Create stub classes for the nodes of a document that have no available class.

    A class that differs from the declaration of the same name is another node, so that a stub replaces it, too.

    Args:
        document: Document with the nodes.
        known: Available node classes, by name.
        models: Declarations of node classes, by name.
        undeclared: Whether a node without a declaration also gets a stub class, which accepts any ports and children.
        everywhere: Elements that use each node class, by its name, in all files that are checked together. The warning
            about an undeclared node is given only in the first of these files.

    Returns:
        Stub classes, and a warning about each undeclared node.
    """
    uses: dict[str, list[Element]] = {}
    for element in document.elements():
        tag = element.node_tag
        if tag and tag not in document.trees and (tag not in known or _is_other(models.get(tag), known[tag])):
            uses.setdefault(tag, []).append(element)
    classes: list[type[Node]] = []
    warnings: list[Fault] = []
    for tag, elements in uses.items():
        if tag in models and models[tag].kind != "SubTree":
            classes.append(_declared(models[tag]))
            if tag in known:
                message = (
                    f"the class {tag} has other ports than the declared node; a stub replaces it{times(elements)}."
                )
                warnings.append(elements[0].fault(message, "Rename the node, if it is another one.", warning=True))
        elif undeclared:
            classes.append(_undeclared(tag, elements))
            warnings += _first(document, tag, everywhere.get(tag) or elements, [*known, *models], tag in everywhere)
    return classes, warnings


def _is_other(model: Model | None, node: type[Node]) -> bool:
    return model is not None and model.kind != "SubTree" and differs(model, node)


def _first(
    document: Document, tag: str, uses: Sequence[Element], names: Sequence[str], elsewhere: bool
) -> Iterator[Fault]:
    """Warning about a stub for an undeclared node.

    If `elsewhere`, `uses` are those of all files checked together, of which only the first gets the warning.
    """
    if not elsewhere or uses[0].source.file == document.root.source.file:
        near = difflib.get_close_matches(tag, names, 1)
        hint = f"Did you mean '{near[0]}'?" if near else "Declare it in a TreeNodesModel to have its ports checked."
        message = f"no node is named '{tag}'; a stub replaces it{times(uses)}."
        yield uses[0].fault(message, hint, warning=True)


def times(uses: Sequence[Element]) -> str:
    """Text with the number of uses of a node or tree, such as ` (3 uses in 2 files)`; empty for a single use."""
    files = len({element.source.file for element in uses})
    return "" if len(uses) == 1 else f" ({len(uses)} uses{f' in {files} files' if files > 1 else ''})"


def _declared(model: Model) -> type[Node]:
    above = model.kind in ("Control", "Decorator")
    ports = {f"port {p.name}": _declared_port(p) for p in model.ports.values()}
    most = {"Control": None, "Decorator": 1}.get(model.kind, 0)
    return _class(StubWithChildren if above else Stub, model.name, model.kind, ports, int(above), most)


def _declared_port(port: ModelPort) -> Field:
    hint: Any = Any
    with contextlib.suppress(InputError):  # an unknown type accepts every value
        hint = annotation(port) if port.type and "::" not in port.type.replace("std::string", "") else Any
    return port_of(hint, port.direction, port.doc, default=port.default or None, name=port.name)


def _undeclared(tag: str, elements: Iterable[Element]) -> type[Node]:
    names = dict.fromkeys(name for element in elements for name in _ports_given(element))
    ports: dict[str, Field] = {f"port {name}": port_of(Any, Direction.INOUT, default=None, name=name) for name in names}
    above = any(element.children for element in elements)
    kind = "Control" if above else "Action"
    return _class(LenientStubWithChildren if above else LenientStub, tag, kind, ports, 0, None if above else 0)


def _ports_given(element: Element) -> Iterator[str]:
    given = (name for name in element.node_attributes() if name not in CONDITIONS)
    return (name for name in given if name != "ID" and not name.startswith("_"))


def _class(
    base: type[Node], tag: str, kind: str, ports: Mapping[str, Field], least: int, most: int | None
) -> type[Node]:
    members = {**ports, "tag": tag, "kind": kind, "min_children": least, "max_children": most, "__module__": __name__}
    return type(tag, (base,), members)


def _broken(name: str, value: Any) -> bool:
    if name not in CONDITIONS:
        return False
    try:
        parse_script(value)
    except ScriptError:
        return True
    return False
