"""Values of the help for editors, and the names that a place in a text takes."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from .marks import faults

_NO_NAME = "zz_no_such_name"


class Item(NamedTuple):
    """Proposal of a completion.

    Attributes:
        label: Text in the list.
        kind: Kind of the thing, such as `port` or `Action`.
        detail: Type, unit and default; empty if unknown.
        doc: Description.
        new: Text to insert; `$1` is where the cursor goes.
        start: Offset of the first replaced character.
        end: Offset after the last one.
    """

    label: str
    kind: str
    detail: str
    doc: str
    new: str
    start: int
    end: int


class Description(NamedTuple):
    """Description of what is at an offset.

    Attributes:
        title: Name.
        detail: Kind, type and unit.
        doc: Description.
        rows: Further lines, such as the ports of a node.
        start: Offset of the first character that it is about.
        end: Offset after the last one.
    """

    title: str
    detail: str
    doc: str
    rows: tuple[str, ...]
    start: int
    end: int


def names_instead(path: Path, text: str, start: int, end: int, *, code: bool = True) -> tuple[str, ...]:
    """Names that are valid instead of a span: those that the check lists for a name that does not exist."""
    tried = text[:start] + _NO_NAME + text[end:]
    line = tried.count("\n", 0, start) + 1
    begin = tried.rfind("\n", 0, start) + 1
    found = [m for m in faults(path, tried, texts=MappingProxyType({}), code=code) if m.file is None and m.names]
    near = [m for m in found if m.line == line and (m.column <= start - begin + len(_NO_NAME) + 1)]
    about = [m for m in near or found if _NO_NAME in m.message]
    return about[0].names if about else ()
