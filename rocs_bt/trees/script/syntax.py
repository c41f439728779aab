"""What a script is made of: the tree that the parser gives and the compiler takes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

Scalar = float | int | str
"""What a script computes with; truth is a number, 1.0 or 0.0."""


@dataclass(frozen=True)
class Literal:
    """A number, a string, `true` or `false`."""

    value: Scalar
    at: int


@dataclass(frozen=True)
class Name:
    """An enum or a key of the board; `@key` is one of the root board."""

    name: str
    at: int


@dataclass(frozen=True)
class Unary:
    """`-`, `~` or `!` and its operand."""

    operator: str
    operand: Expression
    at: int


@dataclass(frozen=True)
class Binary:
    """An arithmetic, bitwise, logical or joining operator between two operands."""

    operator: str
    left: Expression
    right: Expression
    at: int


@dataclass(frozen=True)
class Comparison:
    """A chain such as `1 < x <= 3`: one operand more than operators."""

    operators: tuple[str, ...]
    operands: tuple[Expression, ...]
    at: int


@dataclass(frozen=True)
class Conditional:
    """`condition ? then : otherwise`."""

    condition: Expression
    then: Expression
    otherwise: Expression
    at: int


@dataclass(frozen=True)
class Assignment:
    """`name := value`, which creates a key, or one of `= += -= *= /=`, which need one."""

    operator: str
    target: Name
    value: Expression
    at: int


Expression = Literal | Name | Unary | Binary | Comparison | Conditional | Assignment


def walk(expression: Expression) -> Iterator[Expression]:
    """An expression and all in it, from left to right."""
    yield expression
    for part in parts(expression):
        yield from walk(part)


def parts(expression: Expression) -> tuple[Expression, ...]:
    """What an expression is directly made of, from left to right."""
    match expression:
        case Unary():
            return (expression.operand,)
        case Binary():
            return (expression.left, expression.right)
        case Comparison():
            return expression.operands
        case Conditional():
            return (expression.condition, expression.then, expression.otherwise)
        case Assignment():
            return (expression.target, expression.value)
        case _:
            return ()
