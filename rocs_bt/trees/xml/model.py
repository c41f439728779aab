"""Models: what a TreeNodesModel says of nodes and subtrees: their ports, types, defaults and meaning."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ...errors import Fault, did_you_mean
from ..nodes import Direction
from .element import EXPLICIT, Element

KINDS = (*EXPLICIT, "SubTree")
OWN_NAME = "{=}"
"""What gives a port the key of its own name, but not as a default of a SubTree's model."""

DIRECTIONS = {direction.value: direction for direction in Direction} | {"bidirectional_port": Direction.INOUT}


@dataclass(frozen=True)
class ModelPort:
    """One port of a model.

    Attributes:
        name: Its name.
        direction: Which way values go.
        type: A C++ type such as `double`, or a unit such as `m/s`; empty where nothing is said.
        default: Its value where a tree gives none; None where it has to.
        doc: What it means.
        element: Where it stands.
    """

    name: str
    direction: Direction
    type: str
    default: str | None
    doc: str
    element: Element


@dataclass(frozen=True)
class Model:
    """What a document says of a node, or of a subtree.

    Attributes:
        name: Its ID.
        kind: Action, Condition, Control, Decorator or SubTree.
        ports: Its ports by name.
        element: Where it stands.
    """

    name: str
    kind: str
    ports: dict[str, ModelPort]
    element: Element


def read_models(element: Element, faults: list[Fault]) -> Iterator[Model]:
    """The models in a TreeNodesModel; what is wrong with them is added to `faults`."""
    for child in element.children:
        if child.tag not in KINDS:
            faults.append(child.fault(f"a model is no <{child.tag}>.", did_you_mean(child.tag, KINDS, "A model")))
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
            faults.append(child.fault(f"a port is no <{child.tag}>.", did_you_mean(child.tag, DIRECTIONS, "A port")))
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
