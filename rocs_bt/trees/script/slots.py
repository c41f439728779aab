"""Slots: the names and literals of a script, which are the parameters of its code."""

from __future__ import annotations

from collections.abc import Iterator

from .syntax import Assignment, Expression, Literal, Name, parts, walk


def leaves(statements: tuple[Expression, ...]) -> Iterator[Name | Literal]:
    """The names and literals of some statements, in the order of the text: one per slot."""
    return (e for s in statements for e in walk(s) if isinstance(e, Name | Literal))


class Slots:
    """The slots of some statements.

    Args:
        statements: The statements.
        enums: The slots of texts that are enums; those of names are constants.

    Attributes:
        count: The number of slots.
        enums: The slots of names that are enums.
        names: The slots of names.
        floats: The slots of numbers that are known when the code is made.
    """

    def __init__(self, statements: tuple[Expression, ...], enums: frozenset[int]) -> None:
        found = list(leaves(statements))
        self._slots = {id(leaf): slot for slot, leaf in enumerate(found)}
        self.count = len(found)
        self.names = [i for i, leaf in enumerate(found) if isinstance(leaf, Name)]
        self.enums = enums.intersection(self.names)
        numbers = {i for i, leaf in enumerate(found) if isinstance(leaf, Literal) and not isinstance(leaf.value, str)}
        self.floats = sorted(numbers | self.enums)

    def of(self, leaf: Name | Literal) -> int:
        """The slot of a name or a literal."""
        return self._slots[id(leaf)]

    def is_enum(self, name: Name) -> bool:
        """Whether a name is that of an enum."""
        return self.of(name) in self.enums

    def keys(self, expression: Expression) -> list[int]:
        """The slots of the names whose keys an expression reads."""
        return [self.of(e) for e in _values(expression) if isinstance(e, Name) and not self.is_enum(e)]


def _values(expression: Expression) -> Iterator[Expression]:
    """An expression and all in it whose values are needed; the target of an assignment is not."""
    yield expression
    for part in parts(expression):
        if not (isinstance(expression, Assignment) and part is expression.target):
            yield from _values(part)
