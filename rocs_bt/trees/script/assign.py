"""Assignment to entries of a board: a value keeps the representation that its entry had (`Any::copyInto`)."""

from __future__ import annotations

from typing import Any

from ..board import Board, Entry, from_string
from .arithmetic import BINARY, NUMBERS, Refused, divided, number_of, shown

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


def assign(board: Board, name: str, operator: str, value: Any) -> Any:
    """Assign to a key, and give its new value back.

    Raises:
        Refused: There is no such key, or it cannot take the value.
    """
    entry = (board.entry(name) or board.declare(name)) if operator == ":=" else existing(board, name)
    entry.store(assigned(board, name, entry, operator, value))
    return entry.value


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
    return _kept(entry.value, value)


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


def _kept(old: Any, value: Any) -> Any:
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
