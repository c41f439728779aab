"""From the strings of files to values of ports, and back."""

from __future__ import annotations

import re
from collections.abc import Mapping
from enum import Enum
from typing import Any, get_args, get_origin

from py_trees.common import Status

from ...errors import Fault
from ..error import TreeError
from ..status import outcome_named

_INTEGER = re.compile(r"-?\d+")
_REAL = re.compile(r"-?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|inf|nan)")
_TRUTH = {
    "1": True,
    "true": True,
    "TRUE": True,
    "True": True,
    "0": False,
    "false": False,
    "FALSE": False,
    "False": False,
}

Enums = Mapping[str, int]
"""Names that scripts and enum ports know, and their numbers."""


def from_string(text: str, kind: Any, enums: Enums | None = None) -> Any:
    """A value of a port's type.

    Args:
        text: As it stands in a file; items of a list are separated by `;`.
        kind: bool, int, float, str, Status, an Enum, `list[...]` of them, or Any, which leaves the text as it is.
        enums: Names of numbers, which int, float and Enum ports take too.

    Raises:
        TreeError: It is no such value.
    """
    enums = enums or {}
    if kind is Any or kind is str:
        return text
    if kind is bool:
        return _looked_up(text, _TRUTH, "true or false")
    if kind is int:
        return enums[text] if text in enums else int(_matched(text, _INTEGER, "a whole number"))
    if kind is float:
        return float(enums[text]) if text in enums else float(_matched(text, _REAL, "a number"))
    if get_origin(kind) is list:
        (item,) = get_args(kind)
        return [from_string(part, item, enums) for part in text.split(";")] if text else []
    if kind is Status:
        return outcome_named(text)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return _member(text, kind, enums)
    raise TreeError(Fault(f"{text!r} cannot be read as {kind}: files hold no such values, only the board does."))


def to_string(value: Any) -> str:
    """A value as BehaviorTree.CPP writes it: integers plain, other numbers with six digits."""
    if isinstance(value, bool):
        return str(int(value))
    return f"{value:.6f}" if isinstance(value, float) else str(value)


def _member(text: str, kind: type[Enum], enums: Enums) -> Any:
    if text in kind.__members__:
        return kind[text]
    number = enums.get(text, int(text) if _INTEGER.fullmatch(text) else None)
    for member in kind:
        if member.value == number and number is not None:
            return member
    return _looked_up(text, kind.__members__, f"one of {', '.join(kind.__members__)}")


def _matched(text: str, pattern: re.Pattern[str], what: str) -> str:
    if not pattern.fullmatch(text):
        raise TreeError(Fault(f"{text!r} is not {what}."))
    return text


def _looked_up(text: str, table: Mapping[str, Any], what: str) -> Any:
    if text not in table:
        raise TreeError(Fault(f"{text!r} is not {what}."))
    return table[text]
