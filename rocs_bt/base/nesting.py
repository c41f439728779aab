"""Nested data: walks, and a limit for the depth of JSON from untrusted sources.

JSON decoders recurse in C and rely on Python's recursion limit. A deep behaviour tree raises that limit for the whole
process (see `trees`), so that hostile JSON could then overflow the stack and crash the process.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, TypeVar

T = TypeVar("T")

LIMIT = 500
"""Maximum nesting depth of lists and objects."""

_MARKS = re.compile(rb'"(?:[^"\\]|\\.)*"|[\[{]|[\]}]', re.DOTALL)


def descendants(root: T) -> Iterator[T]:
    """A node, element or the like and all below it in their order, parents before children, without recursion."""
    todo: list[Any] = [root]
    while todo:
        node = todo.pop()
        yield node
        todo += reversed(node.children)


def too_deep(data: str | bytes) -> bool:
    """Whether a JSON text is nested deeper than `LIMIT`. For text that is not JSON, the result is arbitrary."""
    raw = data.encode("utf-8", "surrogatepass") if isinstance(data, str) else data
    if raw.count(b"[") + raw.count(b"{") <= LIMIT:
        return False
    depth = 0
    for mark in _MARKS.findall(raw):
        depth += (mark in b"[{") - (mark in b"]}")
        if depth > LIMIT:
            return True
    return False


def check_nesting(data: str | bytes) -> None:
    """Check that a JSON text is not nested deeper than `LIMIT`.

    Raises:
        ValueError: The text is nested too deeply.
    """
    if too_deep(data):
        raise ValueError(f"lists and objects nest more than {LIMIT} deep")
