"""One value of a board."""

from __future__ import annotations

from typing import Any


class Entry:
    """A value with the type that it was declared with.

    Attributes:
        value: The value; None while there is none.
        kind: The type that a port or a typed write has fixed; None for one that any value may fill.
        sequence: How often it was written.
        alive: False once it was unset, so that who holds it looks anew.
    """

    __slots__ = ("alive", "kind", "sequence", "value")

    def __init__(self, kind: Any = None) -> None:
        self.value: Any = None
        self.kind = kind
        self.sequence = 0
        self.alive = True

    def store(self, value: Any) -> None:
        """Write a value that is known to fit."""
        self.value = value
        self.sequence += 1
