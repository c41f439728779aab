"""Elements of an XML text with their positions, also while the text is being typed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.sax.saxutils import unescape

from ...base.nesting import descendants

NAME = r"[A-Za-z_\u0080-\U0010ffff][\w.\-:\u00b7]*"
"""Regular expression of an XML name."""

ENTITIES = {"&quot;": '"', "&apos;": "'", "&#10;": "\n", "&#9;": "\t", "&#13;": "\r"}
"""Entities of characters in values, besides those of `&`, `<` and `>`."""

_ATTRIBUTE = re.compile(rf"""(\s+)({NAME})(\s*=\s*)("[^"<]*"|'[^'<]*')""")
_TOKEN = re.compile(
    rf"""<!--[\s\S]*?-->|<\?[\s\S]*?\?>|<!\[CDATA\[[\s\S]*?\]\]>|<!DOCTYPE[^>\[]*(?:\[[\s\S]*?\]\s*)?>"""
    rf"""|<(?P<slash>/?)(?P<tag>{NAME})(?P<attributes>(?:\s+{NAME}\s*=\s*(?:"[^"<]*"|'[^'<]*'))*)\s*(?P<empty>/?)>"""
)


@dataclass(frozen=True)
class Attribute:
    """Attribute of an element.

    Attributes:
        name: Name.
        value: Value, with entities resolved.
        start: Offset of the white space before the name.
        at: Offset of the name.
        begin: Offset of the first character of the value, after the quote.
        end: Offset after the closing quote.
    """

    name: str
    value: str
    start: int
    at: int
    begin: int
    end: int


@dataclass(eq=False)
class Element:
    """Element of a text, with offsets into the text.

    Attributes:
        tag: Tag; empty for the document around the root element.
        start: Offset of `<`.
        inner: Offset after the opening tag.
        close: Offset of the closing tag; after an empty element, its end.
        end: Offset after the element.
        parent: Element around it; None for the document.
        empty: Whether it is written as `<Tag/>`.
        attributes: Attributes in the order of the text.
        children: Child elements in the order of the text.
    """

    tag: str
    start: int
    inner: int
    close: int
    end: int
    parent: Element | None = None
    empty: bool = False
    attributes: list[Attribute] = field(default_factory=list)
    children: list[Element] = field(default_factory=list)

    @property
    def path(self) -> tuple[int, ...]:
        """Indices from the document down to this element."""
        path: list[int] = []
        element = self
        while element.parent is not None:
            path.append(element.parent.children.index(element))
            element = element.parent
        return tuple(reversed(path))

    def at(self, path: tuple[int, ...]) -> Element:
        """Element at a path below this one.

        Raises:
            IndexError: There is none.
        """
        element = self
        for index in path:
            element = element.children[index]
        return element

    def value(self, name: str) -> str | None:
        """Value of an attribute; None if it is not given."""
        return next((a.value for a in self.attributes if a.name == name), None)

    def around(self, offset: int) -> Element:
        """Innermost element that contains an offset."""
        return [e for e in descendants(self) if e.start <= offset <= e.end][-1]


def parse(text: str, *, tolerant: bool = False) -> Element | None:
    """Elements of a text; None while the text is not well-formed.

    Args:
        text: Text of a document.
        tolerant: Whether missing and misplaced tags are overlooked, as while a person types.
    """
    document = here = Element("", 0, 0, len(text), len(text))
    for token in _TOKEN.finditer(text):
        tag = token["tag"]
        if not tag:
            continue
        if not token["slash"]:
            element = Element(tag, token.start(), token.end(), token.end(), token.end(), here, bool(token["empty"]))
            element.attributes = [*_attributes(text, token.start("attributes"), token.end("attributes"))]
            here.children.append(element)
            here = here if token["empty"] else element
            continue
        named = next((e for e in _outwards(here) if e.tag == tag), None)
        if named is None or (named is not here and not tolerant):
            if not tolerant:
                return None
            continue
        while here is not named and here.parent is not None:  # elements without a closing tag end where this one does
            here.close = here.end = token.start()
            here = here.parent
        here.close, here.end = token.start(), token.end()
        here = here.parent or document
    while here.parent is not None:
        if not tolerant:
            return None
        here.close = here.end = len(text)
        here = here.parent
    return document


def _outwards(element: Element) -> Iterator[Element]:
    here: Element | None = element
    while here is not None and here.tag:
        yield here
        here = here.parent


def _attributes(text: str, start: int, end: int) -> Iterator[Attribute]:
    for found in _ATTRIBUTE.finditer(text, start, end):
        value = unescape(found[4][1:-1], ENTITIES)
        yield Attribute(found[2], value, found.start(), found.start(2), found.start(4) + 1, found.end())
