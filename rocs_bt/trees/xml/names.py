"""Which names BehaviorTree.CPP 4.10 allows (docs/name_validation_rules.md there); here they are advice, or rules."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ...errors import Fault
from .document import Document
from .element import Element

FORBIDDEN = re.compile(r"""[ \t\r\n<>&"'/\\:*?|.\x00-\x1f\x7f]""")


def name_faults(document: Document, strict: bool) -> Iterator[Fault]:
    """IDs and port names that Groot2 or version 4.10 will not have.

    Args:
        document: The document.
        strict: Whether they are faults; else warnings.
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
    message = f"the {what} name '{name}' holds {found[0]!r}." if found else ""
    if what == "tree" and name in ("Root", "root"):
        message = f"no tree may be named '{name}'."
    if what == "port" and not message and not name[:1].isalpha():
        message = f"the port name '{name}' does not begin with a letter."
    if message:
        hint = "BehaviorTree.CPP 4.10 refuses it; use letters, digits, '_' and '-'."
        yield element.fault(message, hint, attribute=attribute, warning=not strict)
