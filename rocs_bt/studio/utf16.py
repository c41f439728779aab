"""Offsets in UTF-16 code units, in which browsers and the Language Server Protocol count."""

from __future__ import annotations


def units(text: str) -> int:
    """Length of a text in UTF-16 code units."""
    return len(text.encode("utf-16-le")) // 2


def from_units(text: str, count: int) -> int:
    """Number of characters of a text in its first UTF-16 code units."""
    return len(text.encode("utf-16-le")[: 2 * count].decode("utf-16-le", "ignore"))
