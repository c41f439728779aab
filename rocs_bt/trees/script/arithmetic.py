"""What the operators of scripts do, which is what BehaviorTree.CPP's do (scripting/operators.hpp, utils/safe_any.hpp).

Numbers are doubles once they were computed with; an integer literal is an integer until then. A comparison is 1.0 or
0.0. Where C++ would give infinity, so does this. An assigned value keeps the representation that its entry had
(`Any::copyInto`).
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

from ..board import Board, Entry, Enums, from_string, to_string

EPSILON = 2.0**-23
"""Numbers no further apart are equal to `==`: the epsilon of a C++ float."""

NUMBERS = (int, float, bool)


class Refused(Exception):
    """An operator does not take these operands; the compiler says where."""


def number_of(text: str, enums: Enums) -> float:
    """What a string is to a number that it is compared with."""
    if text in ("true", "false"):
        return float(text == "true")
    if text in enums:
        return float(enums[text])
    try:
        return float(text)
    except ValueError:
        raise Refused(f"'{text}' is no number") from None


def truth(value: Any) -> bool:
    """Whether a value holds where a condition is asked.

    Raises:
        Refused: It is neither true nor false: text, or an integer that is not 0 or 1.
    """
    if value.__class__ is float:
        return bool(value != 0.0)
    if isinstance(value, int) and value in (0, 1):
        return value == 1
    raise Refused(f"{shown(value)} is neither true nor false")


def known(value: Any, name: str) -> Any:
    """The value of a key.

    Raises:
        Refused: It has none.
    """
    if value is None:
        raise Refused(f"the board has no value at '{name}'")
    return value


def chosen(value: Any) -> bool:
    """Whether the condition of `?` holds.

    Raises:
        Refused: It is neither true nor false.
    """
    if value.__class__ is not str and value.__class__ not in NUMBERS:
        raise Refused(f"{shown(value)} is neither true nor false")
    return bool(value)


def real(value: float) -> float:
    """A literal as a double, infinite where it is too large for one."""
    try:
        return float(value)
    except OverflowError:
        return math.inf


def shown(value: Any) -> str:
    """A value in a message."""
    return "nothing" if value is None else repr(value)


def divided(left: float, right: float) -> float:
    """A division that knows infinity."""
    if right:
        return left / right
    if not left or math.isnan(left):
        return math.nan
    return math.copysign(math.inf, left) * math.copysign(1.0, right)


def _bits(combine: Callable[[int, int], int]) -> Callable[[Any, Any], float]:
    def combined(left: Any, right: Any) -> float:
        if left != left // 1 or right != right // 1:
            raise Refused("bits are those of whole numbers")
        return float(combine(int(left), int(right)))

    return combined


def _with_numbers(combine: Callable[[Any, Any], float]) -> Callable[[Any, Any], Any]:
    def combined(left: Any, right: Any) -> float:
        if left.__class__ in NUMBERS and right.__class__ in NUMBERS:
            return combine(left, right)
        raise Refused(f"{shown(left)} and {shown(right)} are not both numbers")

    return combined


def added(left: Any, right: Any) -> float | str:
    """`+`: the sum of two numbers, or two strings joined."""
    if left.__class__ is str and right.__class__ is str:
        return str(left + right)
    if left.__class__ in NUMBERS and right.__class__ in NUMBERS:
        return float(left) + float(right)
    raise Refused(f"{shown(left)} and {shown(right)} cannot be added")


def joined(left: Any, right: Any) -> str:
    """`..`: a string and a string or a number."""
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

# The negated forms are those of the source; with NaN they are not the same as the plain ones.
COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "==": lambda a, b: a == b if a.__class__ is str else abs(a - b) <= EPSILON,
    "!=": lambda a, b: a != b if a.__class__ is str else not abs(a - b) <= EPSILON,
    "<": lambda a, b: not a >= b,
    ">": lambda a, b: not a <= b,
    "<=": lambda a, b: not a > b,
    ">=": lambda a, b: not a < b,
}


def comparable(left: Any, right: Any, enums: Enums) -> tuple[Any, Any]:
    """Two values as they are compared: both numbers, or both strings."""
    a, b = left.__class__, right.__class__
    if a is str and b in NUMBERS:
        return number_of(left, enums), right
    if a in NUMBERS and b is str:
        return left, number_of(right, enums)
    if (a is str and b is str) or (a in NUMBERS and b in NUMBERS):
        return left, right
    raise Refused(f"{shown(left)} and {shown(right)} cannot be compared")


def compared(operator: str, left: Any, right: Any, enums: Enums) -> bool:
    """Whether a comparison holds.

    Raises:
        Refused: The values cannot be compared.
    """
    return COMPARE[operator](*comparable(left, right, enums))


def negated(operator_: str, value: Any) -> float:
    """`-`, `~` and `!` of a number."""
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
"""Integers are below it in size."""


def existing(board: Board, name: str) -> Entry:
    """The entry of a key.

    Raises:
        Refused: There is none.
    """
    entry = board.entry(name)
    if entry is None:
        raise Refused(f"there is no '{name}' yet; ':=' makes it")
    return entry


def assigned(board: Board, name: str, entry: Entry, operator: str, value: Any) -> Any:
    """The new value of an entry after an assignment.

    Args:
        board: The board of the script, for enums.
        name: The key.
        entry: Its entry.
        operator: `:=`, `=`, `+=`, `-=`, `*=` or `/=`.
        value: The value on the right.

    Raises:
        Refused: The entry cannot take it.
    """
    try:
        return _assigned(board, name, entry, operator, value)
    except Refused as refused:
        raise Refused(f"'{name}' cannot become {shown(value)}: {refused}") from None


def _assigned(board: Board, name: str, entry: Entry, operator: str, value: Any) -> Any:
    if operator not in (":=", "="):
        value = _combined(entry.value, operator, value)
    elif entry.value is None:
        return value if entry.kind is None else board.fitted(name, entry.kind, value)
    elif value.__class__ is str and entry.value.__class__ is not str:
        if entry.kind is not None:
            return from_string(value, entry.kind, board.enums)
        if entry.value.__class__ in NUMBERS:
            return number_of(value, board.enums)
        raise Refused("it holds no text")
    return _as_stored(entry.value, value)


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
    raise Refused(f"'{operator}' is not for this value")


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
            raise Refused(f"it holds a whole number, and {value} is none")
        if abs(value) >= BITS:
            raise Refused(f"it holds a whole number of 64 bits, and {value} has more")
        return int(value)
    raise Refused(f"it holds a value of type {kind.__name__}")
