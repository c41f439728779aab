"""Names of a rule file that nothing uses."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from ...document import Table
from ...errors import Fault
from ..include import Document

_WORD = re.compile(r"[A-Za-z_]\w*")
_PROSE = frozenset({"doc", "name", "tags", "modes", "trigger", "on_invalid"})


def unused_names(document: Document) -> list[Fault]:
    """Aliases and thresholds that no expression of the file names; warnings. What it includes may serve others, too."""
    root = document.table
    used = {word for text in _texts({key: root.data.get(key) for key in ("alias", "rule")}) for word in words(text)}
    return [
        Fault(
            f"nothing in this file uses the {kind} '{name}'.",
            root.file, *table.place(name),
            hint="Take it out, or use it in a rule.",
            warning=True,
        )
        for kind in ("threshold", "alias")
        for table in [Table(root.file, {}, (kind,), root.places)]
        for name in (root.data[kind] if isinstance(root.data.get(kind), dict) else ())
        if name not in used
    ]  # fmt: skip


def words(text: str) -> set[str]:
    """The names in an expression."""
    return set(_WORD.findall(text))


def _texts(value: Any, key: str = "") -> Iterator[str]:
    """The expressions in a table, not what is written for people."""
    if isinstance(value, Mapping):
        for inner, part in value.items():
            if inner not in _PROSE or isinstance(part, Mapping):
                yield from _texts(part, inner)
    elif isinstance(value, list):
        for part in value:
            yield from _texts(part, key)
    elif isinstance(value, str):
        yield value
