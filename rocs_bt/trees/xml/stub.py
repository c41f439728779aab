"""Stand-ins for nodes that are not here, so that anybody's tree can be looked at and examined."""

from __future__ import annotations

import contextlib
import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from ...errors import Fault, InputError
from ...units import NONE
from ..nodes import BUILTIN, CONDITIONS, Direction, InOut, Input, Leaf, Node, Output, Port
from ..script import ScriptError, parse_script
from ..status import SUCCESS, Outcome
from .document import Document, below
from .element import Element
from .model import Model, ModelPort, annotation

_Sequence: Any = BUILTIN["Sequence"]
_PORTS: Mapping[Direction, type[Port[Any]]] = {
    Direction.INPUT: Input,
    Direction.OUTPUT: Output,
    Direction.INOUT: InOut,
}


class _AcceptsAll(Node):
    """Takes whatever stands there."""

    @classmethod
    def attribute_faults(cls, attributes: Mapping[str, Any]) -> list[tuple[str, Fault]]:
        return []

    def _prepare(self, attributes: Mapping[str, Any]) -> None:
        super()._prepare({n: v for n, v in attributes.items() if not _broken(n, v)})


class LenientStub(_AcceptsAll, Leaf):
    """SUCCESS. Its ports are what its model says, and what its element has besides; any values will do."""

    def update(self) -> Outcome:
        return SUCCESS


class LenientStubWithChildren(_AcceptsAll, _Sequence):  # type: ignore[misc]  # a class that the registry found
    """The same with children: what a Sequence of them comes to."""


def lenient_stub(element: Element, document: Document) -> type[Node]:
    """A class that stands in for what an element names.

    Args:
        element: The element.
        document: The document, whose TreeNodesModel may tell the ports.
    """
    tag = element.attributes.get("ID", "") if element.tag == "SubTree" else element.node_tag
    model = document.models.get(tag)
    ports: dict[str, Port[Any]] = {}
    for port in model.ports.values() if model is not None else ():
        made = _PORTS[port.direction]
        ports[port.name] = made(object, default=port.default, doc=port.doc, name=port.name)
    for name in _ports_given(element):
        if name not in ports:
            ports[name] = InOut(object, None, name=name)
    base = LenientStubWithChildren if element.children else LenientStub
    kind = "Control" if len(element.children) > 1 else "Decorator" if element.children else "Action"
    members = {f"port {name}": port for name, port in ports.items()}  # no name of Python's, so none of the class's own
    return type(tag or "Unnamed", (base,), {**members, "tag": tag or "Unnamed", "kind": kind, "__module__": __name__})


class Stub(Leaf):
    """SUCCESS. A node that a palette declares: its ports are checked as the palette says."""

    def update(self) -> Outcome:
        return SUCCESS


class StubWithChildren(_Sequence):  # type: ignore[misc]  # a class that the registry found
    """The same with children: what a Sequence of them returns."""


def stub_nodes(
    document: Document,
    known: Mapping[str, type[Node]],
    models: Mapping[str, Model],
    *,
    undeclared: bool,
    everywhere: Mapping[str, Sequence[Element]] = MappingProxyType({}),
) -> tuple[list[type[Node]], list[Fault]]:
    """Classes for the nodes of a document that are declared and not here, and warnings of those that nobody declares.

    Args:
        document: The document.
        known: The node classes that are here.
        models: What declares nodes, by ID.
        undeclared: Whether nodes that nothing declares get a class, which takes all ports and any children.
        everywhere: Elements by the node that they name, of all files that are checked together: a name is warned of
            once, in the first of them.
    """
    uses: dict[str, list[Element]] = {}
    for tree in document.trees.values():
        for element in below(tree.body):
            if element.node_tag and element.node_tag not in known and element.node_tag not in document.trees:
                uses.setdefault(element.node_tag, []).append(element)
    classes: list[type[Node]] = []
    warnings: list[Fault] = []
    for tag, elements in uses.items():
        if tag in models and models[tag].kind != "SubTree":
            classes.append(_declared(models[tag]))
        elif undeclared:
            classes.append(_undeclared(tag, elements))
            warnings += _first(document, tag, everywhere.get(tag) or elements, [*known, *models], tag in everywhere)
    return classes, warnings


def _first(
    document: Document, tag: str, uses: Sequence[Element], names: Sequence[str], elsewhere: bool
) -> Iterator[Fault]:
    """The warning of a stub; if other files are checked with this one, in the file that uses the node first."""
    if not elsewhere or uses[0].source.file == document.root.source.file:
        near = difflib.get_close_matches(tag, names, 1)
        hint = f"Did you mean '{near[0]}'?" if near else "Declare it in a TreeNodesModel to have its ports checked."
        message = f"no node is named '{tag}'; a stub takes its place{times(uses)}."
        yield uses[0].fault(message, hint, warning=True)


def times(uses: Sequence[Element]) -> str:
    """How often something is used, and in how many files; empty for once."""
    files = len({element.source.file for element in uses})
    return "" if len(uses) == 1 else f" ({len(uses)} uses{f' in {files} files' if files > 1 else ''})"


def _declared(model: Model) -> type[Node]:
    above = model.kind in ("Control", "Decorator")
    ports = {f"port {p.name}": _declared_port(p) for p in model.ports.values()}
    most = {"Control": None, "Decorator": 1}.get(model.kind, 0)
    return _class(StubWithChildren if above else Stub, model.name, model.kind, ports, int(above), most)


def _declared_port(port: ModelPort) -> Port[Any]:
    made: Any = _PORTS[port.direction]
    kind: Any = object
    dimension: Any = None
    hint: Any = object
    with contextlib.suppress(InputError):  # a type that is not known here takes every value
        hint = annotation(port) if port.type and "::" not in port.type.replace("std::string", "") else object
    if hint in (int, bool, str):
        kind = hint
    elif hint is not object:
        kind, dimension = float, hint.__metadata__[0]
    port_of: Port[Any] = made(kind, default=port.default or None, doc=port.doc, name=port.name, **_of(made, dimension))
    return port_of


def _of(made: type[Port[Any]], dimension: Any) -> dict[str, Any]:
    return {} if made is Output or dimension in (None, NONE) else {"dimension": dimension}


def _undeclared(tag: str, elements: Iterable[Element]) -> type[Node]:
    names = dict.fromkeys(name for element in elements for name in _ports_given(element))
    ports: dict[str, Port[Any]] = {f"port {name}": InOut(object, None, name=name) for name in names}
    above = any(element.children for element in elements)
    kind = "Control" if above else "Action"
    return _class(LenientStubWithChildren if above else LenientStub, tag, kind, ports, 0, None if above else 0)


def _ports_given(element: Element) -> Iterator[str]:
    given = (name for name in element.node_attributes() if name not in CONDITIONS)
    return (name for name in given if name != "ID" and not name.startswith("_"))


def _class(
    base: type[Node], tag: str, kind: str, ports: Mapping[str, Port[Any]], least: int, most: int | None
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
