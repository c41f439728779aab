"""Conversion of documents of version 3 of the format, which BehaviorTree.CPP 3 and Groot 1 write."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from ...base.errors import Fault
from ...base.nesting import descendants
from ..nodes import Direction, Node, pointer
from .element import EXPLICIT, Element
from .model import Model

_RENAMED: Final = {
    "SequenceStar": "SequenceWithMemory",
    "SubTreePlus": "SubTree",
    "RetryUntilSuccesful": "RetryUntilSuccessful",  # spelling of version 3
}
_CHECKS = ("BlackboardCheckInt", "BlackboardCheckDouble", "BlackboardCheckString", "BlackboardCheckBool")
_ONLY_3 = ("SequenceStar", "SubTreePlus", "RetryUntilSuccesful", *_CHECKS)
_ONLY_3_ATTRIBUTES = ("__shared_blackboard", "__autoremap")
_PARALLEL: Final = {"success_threshold": "success_count", "failure_threshold": "failure_count"}
_CHECK_HINT = 'Write <Precondition if="key == value" else="FAILURE"> around the child.'


def is_version_3(root: Element) -> bool:
    """Whether a document declares version 3, or declares no version and uses a feature that only version 3 has."""
    version = root.attributes.get("BTCPP_format", "")
    if version:
        return version == "3"
    outputs = {m.attributes.get("ID", ""): _outputs(m) for m in _models(root)}
    return any(_only_3(element, outputs.get(element.node_tag, ())) for element in descendants(root))


def _models(root: Element) -> Iterator[Element]:
    for child in root.children:
        if child.tag in ("TreeNodesModel", "TreeNodeModel"):
            yield from child.children


def _outputs(model: Element) -> tuple[str, ...]:
    return tuple(port.attributes.get("name", "") for port in model.children if port.tag == "output_port")


def _only_3(element: Element, outputs: tuple[str, ...]) -> bool:
    """Whether an element uses a feature of version 3: a node, an attribute, or an output without braces."""
    given = element.attributes
    if element.node_tag in _ONLY_3 or any(name in given for name in _ONLY_3_ATTRIBUTES):
        return True
    if element.node_tag == "Parallel" and ("threshold" in given or any(name in given for name in _PARALLEL)):
        return True
    return any(given.get(name) and pointer(given[name]) is None for name in outputs)


def convert(root: Element) -> list[Fault]:
    """Convert a document from version 3 to 4 in place; returns warnings, and errors about parts without counterpart.

    Outputs are converted by `convert_outputs`, when the ports of the nodes are known.
    """
    hint = "Save it as version 4: `rocs-bt show FILE --format xml`."
    found = [root.fault("the document is of version 3; it is read as version 4.", hint, warning=True)]
    for element in _nodes(root):
        found += _converted(element)
    return found


def convert_outputs(root: Element, nodes: Mapping[str, type[Node]], models: Mapping[str, Model]) -> None:
    """Write the values of output ports in braces, which version 3 does not need."""
    for element in _nodes(root):
        declared = nodes.get(element.node_tag) or models.get(element.node_tag)
        for name, port in declared.ports.items() if declared is not None else ():
            value = element.attributes.get(name)
            if port.direction is Direction.OUTPUT and value and pointer(value) is None:
                element.attributes[name] = f"{{{value}}}"


def _nodes(root: Element) -> Iterator[Element]:
    for tree in root.children:
        if tree.tag == "BehaviorTree":
            yield from (element for child in tree.children for element in descendants(child))


def _converted(element: Element) -> Iterator[Fault]:
    tag = element.node_tag
    if tag in _CHECKS:
        yield element.fault(f"{tag} does not exist in version 4.", _CHECK_HINT)
    elif tag == "SubTree":
        yield from _subtree(element)
    elif tag == "SubTreePlus":
        _rename(element, "__autoremap", "_autoremap")
    elif tag == "Parallel":
        _parallel(element)
    elif tag == "SetBlackboard" and (key := pointer(element.attributes.get("output_key"))) is not None:
        element.attributes["output_key"] = key  # in version 3, the braces have no meaning
    if tag in _RENAMED:
        if element.tag in EXPLICIT:
            element.attributes["ID"] = _RENAMED[tag]
        else:
            element.tag = _RENAMED[tag]


def _parallel(element: Element) -> None:
    """Rename the thresholds of a Parallel. With `threshold` alone, it fails once it can no longer succeed."""
    for old, new in _PARALLEL.items():
        _rename(element, old, new)
    if "threshold" in element.attributes:
        _rename(element, "threshold", "success_count")
        element.attributes.setdefault("failure_count", "-1")


def _subtree(element: Element) -> Iterator[Fault]:
    """Convert a SubTree element; in version 3 its port values are names of keys, without braces."""
    for name in list(element.attributes):
        value = element.attributes[name]
        if name == "__shared_blackboard":
            if value.lower() in ("true", "1"):
                hint = "Private keys, which begin with '_', are no longer shared."
                message = "__shared_blackboard becomes _autoremap."
                yield element.fault(message, hint, attribute=name, warning=True)
                _rename(element, name, "_autoremap")
            else:
                del element.attributes[name]
        elif name not in ("ID", "name") and not name.startswith("_") and pointer(value) is None:
            element.attributes[name] = f"{{{value}}}"


def _rename(element: Element, old: str, new: str) -> None:
    if old in element.attributes:
        element.attributes = {new if n == old else n: v for n, v in element.attributes.items()}
        element.attribute_positions[new] = element.attribute_positions[old]
