"""Bound on the nesting of JSON from untrusted sources.

Decoders recurse in C and rely on Python's recursion limit. A deep behaviour tree raises that limit for the whole
process (`trees`), so hostile JSON could then overflow the stack and crash the process.
"""

from __future__ import annotations

import re

LIMIT = 500
"""Maximum nesting of lists and objects."""

_MARKS = re.compile(rb'"(?:[^"\\]|\\.)*"|[\[{]|[\]}]', re.DOTALL)


def too_deep(data: str | bytes) -> bool:
    """Whether a JSON text nests deeper than `LIMIT`; may also be True for text that is not JSON."""
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
    """Refuse a JSON text that nests deeper than `LIMIT`.

    Raises:
        ValueError: The text nests too deeply.
    """
    if too_deep(data):
        raise ValueError(f"lists and objects nest more than {LIMIT} deep")
