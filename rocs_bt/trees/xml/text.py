"""From elements to text: one element a line, attributes in their order, so that small changes are small differences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from typing import Any

from py_trees.common import Status

from ...units import NONE, Dimension
from ..status import outcome_name
from .element import Element, Source

WIDTH = 120
"""Where a line is long: its attributes then stand one below the other."""

_ESCAPES = {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;", "\t": "&#9;", "\r": "&#13;"}
_NOWHERE = Source("")


def element(tag: str, attributes: Mapping[str, str], children: Sequence[Element] = (), text: str = "") -> Element:
    """An element that was read from nowhere."""
    made = Element(tag, _NOWHERE, 0)
    made.attributes = dict(attributes)
    made.children = list(children)
    made.text = text
    return made


def to_text(root: Element) -> str:
    """A document, ready to be written to a file."""
    return "\n".join(['<?xml version="1.0" encoding="UTF-8"?>', *_lines(root), ""])


def escape(text: str) -> str:
    """A text as the value of an attribute."""
    return "".join(_ESCAPES.get(c, c) for c in text)


def value_text(value: Any, dimension: Dimension | None = None) -> str:
    """A value of Python's as a file has it.

    Args:
        value: Text, which stays as it is; a number, a truth, a status, an enum, or a list of them.
        dimension: The dimension of its numbers, which are SI; None or NONE for plain ones.
    """
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Status):
        return outcome_name(value)
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, (list, tuple)):
        pairs = any(isinstance(item, (list, tuple)) for item in value)
        return ";".join(_point(item, dimension) if pairs else value_text(item, dimension) for item in value)
    unit = "" if dimension in (None, NONE) else f" {dimension}"
    return f"{value!r}{unit}"


def _point(point: Sequence[Any], dimension: Dimension | None) -> str:
    return ",".join(value_text(x, dimension) for x in point)


def _lines(root: Element) -> Iterator[str]:
    todo: list[tuple[Element | str, int]] = [(root, 0)]
    while todo:
        item, depth = todo.pop()
        indent = "  " * depth
        if isinstance(item, str):
            yield indent + item
            continue
        for comment in item.comments:
            yield f"{indent}<!--{comment}-->"
        opening = _opening(item, indent)
        if item.children:
            yield f"{opening}>"
            todo.append((f"</{item.tag}>", depth))
            todo += [(child, depth + 1) for child in reversed(item.children)]
        elif item.text:
            yield f"{opening}>{item.text.replace('&', '&amp;').replace('<', '&lt;').replace('>', '&gt;')}</{item.tag}>"
        else:
            yield f"{opening}/>"


def _opening(item: Element, indent: str) -> str:
    attributes = [f'{name}="{escape(value)}"' for name, value in item.attributes.items()]
    line = " ".join([f"{indent}<{item.tag}", *attributes])
    if len(line) <= WIDTH:
        return line
    return f"\n{indent}    ".join([f"{indent}<{item.tag}", *attributes])
