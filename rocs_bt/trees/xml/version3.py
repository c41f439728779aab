"""Documents of BehaviorTree.CPP version 3, turned into version 4 in place, with a notice for each change of meaning.

What changed, after BehaviorTree.CPP's migration page and convert_v3_to_v4.py.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...errors import Fault
from .element import EXPLICIT, Element

_RENAMED = {
    "SequenceStar": "SequenceWithMemory",
    "SubTreePlus": "SubTree",
    "RetryUntilSuccesful": "RetryUntilSuccessful",  # version 3 spelt it so
}
_ONLY_3 = ("SequenceStar", "SubTreePlus", "BlackboardCheckInt", "BlackboardCheckDouble", "BlackboardCheckString",
           "BlackboardCheckBool")  # fmt: skip
_ONLY_3_ATTRIBUTES = ("__shared_blackboard", "__autoremap")
_CHECKS = 'Write <Precondition if="key == value" else="FAILURE"> around the child.'


def is_version_3(root: Element) -> bool:
    """Whether a document says that it is of version 3, or says nothing and has what only version 3 has."""
    said = root.attributes.get("BTCPP_format", "")
    if said:
        return said == "3"
    return any(e.node_tag in _ONLY_3 or any(a in e.attributes for a in _ONLY_3_ATTRIBUTES) for e in below(root))


def below(root: Element) -> Iterator[Element]:
    """An element and all in it, in the order of the text."""
    todo = [root]
    while todo:
        element = todo.pop()
        yield element
        todo += reversed(element.children)


def convert(root: Element) -> list[Fault]:
    """Turn a document of version 3 into one of version 4; the notices are warnings, but for what cannot be turned."""
    hint = "Save it as version 4: `rocs-bt show FILE --format xml`."
    found = [root.fault("the document is of version 3; it is read as version 4.", hint, warning=True)]
    for tree in root.children:
        if tree.tag == "BehaviorTree":
            for element in below(tree):
                found += _converted(element)
    return found


def _converted(element: Element) -> Iterator[Fault]:
    tag = element.node_tag
    if tag.startswith("BlackboardCheck"):
        yield element.fault(f"{tag} does not exist in version 4.", _CHECKS)
    if tag == "SubTree":
        yield from _subtree(element)
    elif tag == "SubTreePlus":
        _rename(element, "__autoremap", "_autoremap")
    if tag in _RENAMED:
        if element.tag in EXPLICIT:
            element.attributes["ID"] = _RENAMED[tag]
        else:
            element.tag = _RENAMED[tag]


def _subtree(element: Element) -> Iterator[Fault]:
    """In version 3 what a SubTree gave for a port was the name of a key."""
    for name in list(element.attributes):
        value = element.attributes[name]
        if name == "__shared_blackboard":
            if value.lower() in ("true", "1"):
                hint = "Private keys, which begin with '_', are not shared any more."
                message = "__shared_blackboard becomes _autoremap."
                yield element.fault(message, hint, attribute=name, warning=True)
                _rename(element, name, "_autoremap")
            else:
                del element.attributes[name]
        elif name not in ("ID", "name") and not name.startswith("_") and not value.startswith("{"):
            element.attributes[name] = f"{{{value}}}"


def _rename(element: Element, old: str, new: str) -> None:
    if old in element.attributes:
        element.attributes = {new if n == old else n: v for n, v in element.attributes.items()}
        element.spots[new] = element.spots[old]
