"""Stand-ins for nodes that are not here, so that anybody's tree can be looked at and examined."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...errors import Fault
from ..nodes import BUILTIN, CONDITIONS, Direction, InOut, Input, Leaf, Node, Output, Port
from ..script import ScriptError, parse_script
from ..status import SUCCESS, Outcome
from .document import Document
from .element import Element

_Sequence: Any = BUILTIN["Sequence"]
_PORTS: Mapping[Direction, type[Port[Any]]] = {
    Direction.INPUT: Input,
    Direction.OUTPUT: Output,
    Direction.INOUT: InOut,
}


class _Anything(Node):
    """Takes whatever stands there."""

    @classmethod
    def attribute_faults(cls, attributes: Mapping[str, Any]) -> list[tuple[str, Fault]]:
        return []

    def _prepare(self, attributes: Mapping[str, Any]) -> None:
        super()._prepare({n: v for n, v in attributes.items() if not _broken(n, v)})


class StandIn(_Anything, Leaf):
    """SUCCESS. Its ports are what its model says, and what its element has besides; any values will do."""

    def update(self) -> Outcome:
        return SUCCESS


class StandInAbove(_Anything, _Sequence):  # type: ignore[misc]  # a class that the registry found
    """The same with children: what a Sequence of them comes to."""


def stand_in(element: Element, document: Document) -> type[Node]:
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
    for name in element.node_attributes():
        if name not in ports and name not in CONDITIONS and name != "ID" and not name.startswith("_"):
            ports[name] = InOut(object, None, name=name)
    base = StandInAbove if element.children else StandIn
    kind = "Control" if len(element.children) > 1 else "Decorator" if element.children else "Action"
    members = {f"port {name}": port for name, port in ports.items()}  # no name of Python's, so none of the class's own
    return type(tag or "Unnamed", (base,), {**members, "tag": tag or "Unnamed", "kind": kind, "__module__": __name__})


def _broken(name: str, value: Any) -> bool:
    if name not in CONDITIONS:
        return False
    try:
        parse_script(value)
    except ScriptError:
        return True
    return False
