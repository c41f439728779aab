"""Operators of scripts, equivalent to those of BehaviorTree.CPP (scripting/operators.hpp, utils/safe_any.hpp).

The result of arithmetic is a double; an integer literal is an integer until an operator is applied. The value of a
comparison is 1.0 or 0.0. A result is infinite where that of C++ is. An assignment converts the new value to the type
of the entry's previous value (`Any::copyInto`).
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from enum import Enum
from typing import Any

from py_trees.common import Status

from ..board import Board, BoardEntry
from ..status import Skip
from ..value import TRUTH, Enums, converted, numeric, to_string

EPSILON = 2.0**-23
"""Tolerance of `==` for numbers: the epsilon of a C++ float."""

NUMBERS = (int, float, bool)


class Refused(Exception):
    """Raised if an operator does not accept its operands. The compiler converts it to a ScriptError."""


def number_of(text: str, enums: Enums) -> float:
    """Numeric value of a string in a comparison with a number."""
    if text in TRUTH:
        return float(TRUTH[text])
    if text in enums:
        return float(enums[text])
    try:
        return float(text)
    except ValueError:
        raise Refused(f"'{text}' is not a number") from None


def truth(value: Any) -> bool:
    """Truth of a value used as a condition.

    Raises:
        Refused: The value is neither true nor false: a text that is no truth value, or an integer that is not 0 or 1.
    """
    if value.__class__ is float:
        return bool(value != 0.0)
    if value.__class__ is str and value in TRUTH:  # a subtree's attribute such as enabled="false"
        return TRUTH[value]
    if isinstance(value, int) and value in (0, 1):
        return value == 1
    raise Refused(f"{shown(value)} is neither true nor false")


def required_value(value: Any, name: str) -> Any:
    """Check that a key has a value, and return the value.

    Raises:
        Refused: The key has no value.
    """
    if value is None:
        raise Refused(f"the board has no value at '{name}'")
    return value


def choice_truth(value: Any) -> bool:
    """Truth of the condition of `?`, which, unlike other conditions, may be any text or number.

    Raises:
        Refused: The value is neither true nor false.
    """
    if value.__class__ is not str and value.__class__ not in NUMBERS:
        raise Refused(f"{shown(value)} is neither true nor false")
    return TRUTH.get(value, bool(value)) if value.__class__ is str else bool(value)


def as_double(value: float) -> float:
    """Literal as a double, infinite if it is too large."""
    try:
        return float(value)
    except OverflowError:
        return math.inf


def shown(value: Any) -> str:
    """Text of a value for a message."""
    return "nothing" if value is None else repr(value)


def divided(left: float, right: float) -> float:
    """Division that returns infinity or NaN for a zero divisor."""
    if right:
        return left / right
    if not left or math.isnan(left):
        return math.nan
    return math.copysign(math.inf, left) * math.copysign(1.0, right)


def _bits(combine: Callable[[int, int], int]) -> Callable[[Any, Any], float]:
    def combined(left: Any, right: Any) -> float:
        if left != left // 1 or right != right // 1:
            raise Refused("bitwise operators need whole numbers")
        return float(combine(int(left), int(right)))

    return combined


def _with_numbers(combine: Callable[[Any, Any], float]) -> Callable[[Any, Any], Any]:
    def combined(left: Any, right: Any) -> float:
        if left.__class__ in NUMBERS and right.__class__ in NUMBERS:
            return combine(left, right)
        raise Refused(f"{shown(left)} and {shown(right)} are not both numbers")

    return combined


def added(left: Any, right: Any) -> float | str:
    """`+`: sum of two numbers, or concatenation of two strings."""
    if left.__class__ is str and right.__class__ is str:
        return str(left + right)
    if left.__class__ in NUMBERS and right.__class__ in NUMBERS:
        return float(left) + float(right)
    raise Refused(f"{shown(left)} and {shown(right)} cannot be added")


def joined(left: Any, right: Any) -> str:
    """`..`: concatenation of a string and a string or number."""
    if str not in (left.__class__, right.__class__) or None in (left, right):
        raise Refused(f"{shown(left)} and {shown(right)} cannot be joined")
    return to_string(left) + to_string(right)


BINARY: dict[str, Callable[[Any, Any], Any]] = {
    "+": added,
    "..": joined,
    "-": _with_numbers(lambda a, b: float(a) - float(b)),
    "*": _with_numbers(lambda a, b: float(a) * float(b)),
    "/": _with_numbers(lambda a, b: divided(float(a), float(b))),
    "&": _with_numbers(_bits(operator.and_)),
    "|": _with_numbers(_bits(operator.or_)),
    "^": _with_numbers(_bits(operator.xor)),
}

# The negated forms are those of the C++ source; with NaN they differ from the plain ones.
COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "==": lambda a, b: a == b if a.__class__ is str else abs(a - b) <= EPSILON,
    "!=": lambda a, b: a != b if a.__class__ is str else not abs(a - b) <= EPSILON,
    "<": lambda a, b: not a >= b,
    ">": lambda a, b: not a <= b,
    "<=": lambda a, b: not a > b,
    ">=": lambda a, b: not a < b,
}


def comparable(left: Any, right: Any, enums: Enums) -> tuple[Any, Any]:
    """Convert the operands of a comparison so that both are numbers or both are strings.

    Raises:
        Refused: The operands cannot be compared.
    """
    if isinstance(left, Enum) or isinstance(right, Enum):
        left, right = _enum_operands(left, right)
    a, b = left.__class__, right.__class__
    if a is str and b in NUMBERS:
        return number_of(left, enums), right
    if a in NUMBERS and b is str:
        return left, number_of(right, enums)
    if (a is str and b is str) or (a in NUMBERS and b in NUMBERS):
        return left, right
    raise Refused(f"{shown(left)} and {shown(right)} cannot be compared")


def _enum_operands(left: Any, right: Any) -> tuple[Any, Any]:
    """Operands of a comparison with an enum value: its name if the other operand is a text, else its number."""
    if left.__class__ is right.__class__ or str in (left.__class__, right.__class__):
        return converted(left, str), converted(right, str)
    return numeric(left), numeric(right)


def compared(operator: str, left: Any, right: Any, enums: Enums) -> bool:
    """Whether a comparison is true.

    Raises:
        Refused: The values cannot be compared.
    """
    return COMPARE[operator](*comparable(left, right, enums))


def negated(operator_: str, value: Any) -> float:
    """Unary `-`, `~` and `!` of a number."""
    if operator_ == "!" and value.__class__ is str and value in TRUTH:
        return float(not TRUTH[value])
    value = numeric(value)
    if value.__class__ not in NUMBERS:
        raise Refused(f"'{operator_}' takes a number, not {shown(value)}")
    if operator_ == "-":
        return -float(value)
    if operator_ == "!":
        return float(not value)
    if not abs(value) < 2.0**63:
        raise Refused(f"{value} does not fit into 64 bits")
    return float(~int(value))


BITS = 2.0**63
"""Limit of the magnitude of a 64-bit integer."""


def existing_entry(board: Board, name: str) -> BoardEntry:
    """Entry of a key that must exist.

    Raises:
        Refused: The key does not exist.
    """
    entry = board.entry(name)
    if entry is None:
        raise Refused(f"the key '{name}' does not exist; ':=' creates it")
    return entry


def assigned(board: Board, name: str, entry: BoardEntry, operator: str, value: Any) -> Any:
    """Compute the new value of an entry for an assignment.

    Raises:
        Refused: The entry cannot hold the value.
    """
    try:
        return _assigned(board, name, entry, operator, value)
    except Refused as refused:
        raise Refused(f"'{name}' cannot become {shown(value)}: {refused}") from None


def _assigned(board: Board, name: str, entry: BoardEntry, operator: str, value: Any) -> Any:
    if operator not in (":=", "="):
        value = _combined(entry.value, operator, value)
    elif entry.value is None:
        return value if entry.kind is None else _fitted(board, name, entry, value)
    elif value.__class__ is str and entry.value.__class__ is not str:
        if entry.kind is not None:
            return _fitted(board, name, entry, value)
        if entry.value.__class__ in NUMBERS:
            return number_of(value, board.enums)
        if not isinstance(entry.value, Enum):
            raise Refused("it holds no text")
    if entry.declared and entry.kind is not str:
        return _fitted(board, name, entry, value)
    if isinstance(entry.value, Enum) and entry.value.__class__ is not value.__class__:
        kind: Any = Status if isinstance(entry.value, Skip) else type(entry.value)
        return converted(value, kind, board.enums)
    return _as_stored(entry.value, value)


def _fitted(board: Board, name: str, entry: BoardEntry, value: Any) -> Any:
    """Value of an entry with a type; raises Refused."""
    number = value.__class__ in NUMBERS and entry.kind is int
    return _as_stored(0, value) if number else board.fitted(name, entry, value)


def _combined(old: Any, operator: str, value: Any) -> Any:
    if old is None:
        raise Refused("it has no value yet")
    if value.__class__ in NUMBERS:
        if old.__class__ not in NUMBERS:
            raise Refused("it holds no number")
        a, b = float(old), float(value)
        return divided(a, b) if operator == "/=" else BINARY[operator[0]](a, b)
    if operator == "+=" and value.__class__ is str:
        return _text(old) + value
    raise Refused(f"'{operator}' does not accept this value")


def _text(value: Any) -> str:
    if value.__class__ not in (str, *NUMBERS):
        raise Refused("it holds no text")
    return str(BINARY[".."](value, ""))


def _as_stored(old: Any, value: Any) -> Any:
    kind, given = old.__class__, value.__class__
    if kind is given:
        return value
    if kind in NUMBERS and given in NUMBERS:
        if kind is float:
            return float(value)
        if given is float and not value.is_integer():
            raise Refused(f"it holds a whole number, but {value} is none")
        if abs(value) >= BITS:
            raise Refused(f"it holds a 64-bit whole number, but {value} is larger")
        return int(value)
    raise Refused(f"it holds a value of type {kind.__name__}")
