"""How counts are told."""

from __future__ import annotations


def counted(number: int, thing: str, plural: str = "s") -> str:
    """A number of things in words: `1 scene`, `20 scenes`, `2 switches` with `plural="es"`."""
    return f"{number} {thing}{'' if number == 1 else plural}"
