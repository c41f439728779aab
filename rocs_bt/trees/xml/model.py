"""Models: declarations of nodes and subtrees in a TreeNodesModel, with the type and default of each port."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from ...base.errors import Fault, InputError, did_you_mean
from ...base.units import NONE, parse_quantity, parse_unit
from ..nodes import Direction, Node
from .element import EXPLICIT, Element

KINDS = (*EXPLICIT, "SubTree")
OWN_NAME = "{=}"
"""Port value that means the key with the port's own name, except as a default in a SubTree's model."""

DIRECTIONS = {direction.value: direction for direction in Direction} | {"bidirectional_port": Direction.INOUT}


@dataclass(frozen=True)
class ModelPort:
    """Port that a model declares.

    Attributes:
        name: Name of the port.
        direction: Whether the node reads the port, writes it, or both.
        type: C++ type such as `double`, or unit such as `m/s`; empty if not declared.
        default: Default value; None if a tree must give a value.
        doc: Description of the port.
        element: XML element that declares the port.
    """

    name: str
    direction: Direction
    type: str
    default: str | None
    doc: str
    element: Element


@dataclass(frozen=True)
class Model:
    """Declaration of a node class or a subtree in a document.

    Attributes:
        name: Name of the node class, or ID of the tree.
        kind: Action, Condition, Control, Decorator or SubTree.
        ports: Ports by name.
        element: XML element of the declaration.
    """

    name: str
    kind: str
    ports: dict[str, ModelPort]
    element: Element

    def metadata(self) -> Iterator[Element]:
        """Elements `<Metadata key="value"/>` of the declaration, which Groot2 keeps."""
        for fields in self.element.children:
            yield from fields.children if fields.tag == "MetadataFields" else ()


def read_models(element: Element, faults: list[Fault]) -> Iterator[Model]:
    """Read the models in a TreeNodesModel."""
    for child in element.children:
        if child.tag not in KINDS:
            faults.append(
                child.fault(f"<{child.tag}> is not a kind of model.", did_you_mean(child.tag, KINDS, "A model"))
            )
        elif not child.attributes.get("ID"):
            faults.append(child.fault("the model has no ID.", 'Write ID="Name".'))
        else:
            ports = {p.name: p for p in _ports(child, faults)}
            yield Model(child.attributes["ID"], child.tag, ports, child)


def _ports(element: Element, faults: list[Fault]) -> Iterator[ModelPort]:
    for child in element.children:
        if child.tag == "MetadataFields":
            continue
        if child.tag not in DIRECTIONS:
            faults.append(
                child.fault(f"<{child.tag}> is not a kind of port.", did_you_mean(child.tag, DIRECTIONS, "A port"))
            )
        elif not child.attributes.get("name"):
            faults.append(child.fault("the port has no name.", 'Write name="port".'))
        else:
            given = child.attributes
            direction = DIRECTIONS[child.tag]
            default = given.get("default")
            if element.tag == "SubTree" and default == OWN_NAME:
                message = f"as in BehaviorTree.CPP this default is the key '=', not the key '{given['name']}'."
                hint = f'Write default="{{{given["name"]}}}".'
                faults.append(child.fault(message, hint, attribute="default", warning=True))
            yield ModelPort(given["name"], direction, given.get("type", ""), default, child.text, child)


def differs(model: Model, node: type[Node]) -> bool:
    """Whether a model declares another node than the class of the same name: other ports, or other children.

    A class may have optional ports that the model omits.
    """
    leaf = model.kind in ("Action", "Condition")
    if leaf != (node.max_children == 0):
        return True
    if any(port.required and name not in model.ports for name, port in node.ports.items()):
        return True
    return any(
        name not in node.ports or {port.direction, node.ports[name].direction} == {Direction.INPUT, Direction.OUTPUT}
        for name, port in model.ports.items()
    )


_WHOLE = frozenset(
    ["int", "unsigned", "unsigned int", "short", "unsigned short", "long", "unsigned long", "long long", "size_t"]
    + [f"{sign}int{bits}{t}" for sign in ("", "u") for bits in (8, 16, 32, 64) for t in ("", "_t")]
)
_REAL = ("double", "float", "long double")
_QUALIFIERS = re.compile(r"\bconst\b|\bstd::(?=size_t|u?int\d)|[&*]")
_CLASS = re.compile(r"\w+(?:::\w+)+|[\w:]+<.+>|[A-Z][a-z0-9]\w*|char")
_TEXT = ("", "std::string", "string", "BT::AnyTypeAllowed", "AnyTypeAllowed")


def annotation(port: ModelPort) -> Any:
    """Python annotation for the values of a port: the type, and the dimension of a quantity.

    Values of C++ classes such as `geometry_msgs::msg::PoseStamped` or `std::vector<double>` are kept as text; the node
    that reads such a port parses it.

    Raises:
        InputError: The type is neither a C++ type nor a unit.
    """
    kind = _QUALIFIERS.sub("", port.type).strip()
    if kind in _WHOLE:
        return int
    if kind == "bool":
        return bool
    if kind in _TEXT:
        return str
    if kind in _REAL:
        of = NONE if port.default is None else parse_quantity(port.default).dimension
        return float if of == NONE else Annotated[float, of]
    try:
        return Annotated[float, parse_unit(kind).dimension]
    except InputError:
        if _CLASS.fullmatch(kind):
            return str
        raise
