"""Texts of counts, for messages."""

from __future__ import annotations


def counted(number: int, noun: str, plural: str = "s") -> str:
    """Text of a count with its noun: `1 scene`, `20 scenes`, `2 switches` with `plural="es"`."""
    return f"{number} {noun}{'' if number == 1 else plural}"
