"""XML elements of a document, with the position of each attribute."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from ...base.errors import Fault
from ...base.raised import CodeLocation

NAME = r"[A-Za-z_\u0080-\U0010ffff][\w.\-:\u00b7]*"
"""Regular expression of an XML name."""

ATTRIBUTE = re.compile(rf"[ \t\r\n]*({NAME})[ \t\r\n]*=[ \t\r\n]*([\"'])")
"""Regular expression of an attribute, up to and including the opening quote."""

_OPENING = re.compile(rf"<{NAME}")

EXPLICIT = ("Action", "Condition", "Control", "Decorator")
"""Tags of the explicit form of a node, such as `<Action ID="GoTo"/>` instead of `<GoTo/>`."""


class Source:
    """Text of a document, and the file from which it was read.

    Args:
        text: Text of the document.
        file: Path of the file; None for a text that is not in a file.
    """

    def __init__(self, text: str, file: Path | None = None) -> None:
        self.text = text
        self.file = file
        self._lines: list[int] = []

    def position(self, at: int) -> tuple[int, int]:
        """Line and column of an offset in the text, both counted from 1."""
        if not self._lines:
            self._lines = [0, *(i + 1 for i, c in enumerate(self.text) if c == "\n")]
        line = bisect_right(self._lines, at)
        return line, at - self._lines[line - 1] + 1

    def fault(self, at: int, message: str, hint: str = "", *, warning: bool = False) -> Fault:
        """Create a fault at an offset in the text."""
        return Fault(message, self.file, *self.position(at), hint=hint, warning=warning)


class AttributePosition(NamedTuple):
    """Offsets in the text of an attribute's name and of the first character of its value."""

    name: int
    value: int


NO_CHILDREN: Any = ()
"""Children of an element without children; shared by all of them to save memory."""


class Element:
    """XML element of a document.

    Attributes:
        tag: Tag of the element.
        source: Text of the document that contains the element.
        at: Offset of the element's `<` in the text.
        attributes: Values of the attributes by name, in order, with entities resolved.
        children: Child elements, in order.
        text: Text inside the element, without the text of its children.
        comments: Comments directly before the element.
    """

    __slots__ = ("_attribute_positions", "at", "attributes", "children", "comments", "source", "tag", "text")

    def __init__(
        self,
        tag: str,
        source: Source,
        at: int,
        attributes: dict[str, str] | None = None,
        comments: tuple[str, ...] = (),
    ) -> None:
        self.tag = tag
        self.source = source
        self.at = at
        self.attributes = {} if attributes is None else attributes
        self.children: list[Element] = NO_CHILDREN
        self.text = ""
        self.comments = comments
        self._attribute_positions: dict[str, AttributePosition] | None = None

    @property
    def attribute_positions(self) -> dict[str, AttributePosition]:
        """Position of each attribute; computed on first access, because most documents have no faults."""
        if self._attribute_positions is None:
            self._attribute_positions = dict(_attribute_positions(self.source.text, self.at))
        return self._attribute_positions

    @property
    def node_tag(self) -> str:
        """Name of the node class: the attribute `ID` in the explicit form `<Action ID="GoTo"/>`, else the tag."""
        return self.attributes.get("ID", "") if self.tag in EXPLICIT else self.tag

    @property
    def node_name(self) -> str:
        """Name of the node: its attribute `name`, else the name of its class or subtree."""
        return self.attributes.get("name") or self.attributes.get("ID") or self.tag

    @property
    def location(self) -> CodeLocation | None:
        """File and line of the element; None for a text that is not in a file."""
        file = self.source.file
        return None if file is None else CodeLocation(file, self.source.position(self.at)[0])

    def node_attributes(self) -> dict[str, str]:
        """Attributes for the node's constructor: all except `name`, and except an `ID` that names the node class."""
        given = self.attributes
        if not given or (len(given) == 1 and "name" in given):
            return {}
        return {n: v for n, v in given.items() if n != "name" and (n != "ID" or self.tag == "SubTree")}

    def fault(
        self,
        message: str,
        hint: str = "",
        *,
        attribute: str = "",
        column: int | None = None,
        path: str = "",
        warning: bool = False,
    ) -> Fault:
        """Create a fault at this element, at one of its attributes, or within an attribute's value.

        Args:
            message: Description of the fault.
            hint: Suggested remedy.
            attribute: Name of the attribute; the fault is at the element itself if it has no such attribute.
            column: Position in the attribute's value, counted from 0.
            path: Path of the node, which is prepended to the message.
            warning: Whether the fault is a warning, so that the document can still be loaded.
        """
        position = self.attribute_positions.get(attribute)
        at = self.at if position is None else position.name if column is None else self._inside(position.value, column)
        return self.source.fault(at, f"{path}: {message}" if path else message, hint, warning=warning)

    def _inside(self, at: int, column: int) -> int:
        """Offset in the text of a character of an attribute's value; entities such as `&lt;` count as one character."""
        text = self.source.text
        for _ in range(column):
            end = text.find(";", at, at + 10) if text[at : at + 1] == "&" else -1
            at = end + 1 if end > 0 and unescape(text[at : end + 1]) != text[at : end + 1] else at + 1
        return at


def _attribute_positions(text: str, at: int) -> Iterator[tuple[str, AttributePosition]]:
    """Name and position of each attribute of the element that begins at an offset."""
    opening = _OPENING.match(text, at)
    at = opening.end() if opening else len(text)
    while found := ATTRIBUTE.match(text, at):
        yield found[1], AttributePosition(found.start(1), found.end())
        at = text.find(found[2], found.end()) + 1
        if not at:
            return


_ENTITIES = {"lt": "<", "gt": ">", "quot": '"', "apos": "'", "amp": "&"}  # `amp` last: its result is not resolved again


def unescape(text: str) -> str:
    """Replace XML's five entities and character references by their characters; any other `&` is unchanged."""
    if "&" not in text:
        return text
    if "&#" not in text:
        for entity, meant in _ENTITIES.items():
            text = text.replace(f"&{entity};", meant)
        return text
    first, *rest = text.split("&")
    found = [first]
    for part in rest:
        name, semicolon, after = part.partition(";")
        character = _character(name) if semicolon else None
        found.append(f"&{part}" if character is None else character + after)
    return "".join(found)


def _character(name: str) -> str | None:
    if not name.startswith("#"):
        return _ENTITIES.get(name)
    digits, base = (name[2:], 16) if name[1:2] == "x" else (name[1:], 10)
    if not 0 < len(digits) <= 8 or not digits.isalnum() or not digits.isascii():
        return None
    try:
        code = int(digits, base)
    except ValueError:
        return None
    allowed = code in (9, 10, 13) or 0x20 <= code < 0xD800 or 0xE000 <= code < 0xFFFE or 0x10000 <= code < 0x110000
    return chr(code) if allowed else None
