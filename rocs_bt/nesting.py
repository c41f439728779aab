"""A bound on how deep JSON from outside may nest.

Decoders recurse in C and rely on Python's recursion limit, which a deep behaviour tree raises for the whole process
(`trees`): a hostile text would then overflow the stack and end the process.
"""

from __future__ import annotations

import re

LIMIT = 500
"""Lists and objects within each other, at most."""

_MARKS = re.compile(rb'"(?:[^"\\]|\\.)*"|[\[{]|[\]}]', re.DOTALL)


def too_deep(data: str | bytes) -> bool:
    """Whether a JSON text nests deeper than `LIMIT`; a text that is no JSON may count as such."""
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
        ValueError: It does.
    """
    if too_deep(data):
        raise ValueError(f"lists and objects nest more than {LIMIT} deep")
