"""Conversion of values: the one rule for how a value becomes a value of a port's or a key's type.

The rule does not depend on where the value comes from: a literal of a file, a script, an attribute of a subtree, a
default, JSON or Python code. `docs/missions-rules.md` has it as a table, which a test reads.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from enum import Enum
from typing import Any, get_args, get_origin

from py_trees.common import Status

from ..base.errors import Fault
from .error import TreeError
from .status import Skip, outcome_name, outcome_named

_INTEGER = re.compile(r"-?\d+")
_REAL = re.compile(r"-?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|inf|nan)")
_JSON = "json:"

TRUTH: Mapping[str, bool] = {
    "1": True,
    "true": True,
    "TRUE": True,
    "True": True,
    "0": False,
    "false": False,
    "FALSE": False,
    "False": False,
}
"""Texts that are truth values."""

STATUS_NAMES = ("IDLE", "RUNNING", "SUCCESS", "FAILURE", "SKIPPED")
"""Names of the outcomes, in the order of their numbers in BehaviorTree.CPP."""

Enums = Mapping[str, int]
"""Enum values, keyed by the names that scripts and ports may use for them."""

_NO_ENUMS: Enums = {}


def converted(value: Any, kind: Any, enums: Enums = _NO_ENUMS) -> Any:
    """Convert a value to a type.

    Args:
        value: Text, number, truth value, enum value, list or any other object.
        kind: bool, int, float, str, Status, an Enum, `list[...]` of them, a class, or Any, which accepts every value.
        enums: Numbers by name, for texts.

    Raises:
        TreeError: The value cannot be converted, or would lose something.
    """
    given = value.__class__
    if given is kind or kind is Any:
        return value
    if given is str:
        return from_string(value, kind, enums)
    if kind in (bool, int, float):
        return _number(value, kind)
    if kind is str:
        return _text(value)
    if get_origin(kind) is list:
        return _items(value, kind, enums)
    if kind is Status:
        return _outcome(value)
    if isinstance(kind, type):
        if isinstance(value, kind):
            return value
        if issubclass(kind, Enum) and not isinstance(value, Enum) and (number := _plain_number(value)) is not None:
            return _numbered(number, kind)
    raise _unfit(value, kind)


def from_string(text: str, kind: Any, enums: Enums | None = None) -> Any:
    """Convert text to the type of a port.

    Args:
        text: Text as in a file; items of a list are separated by `;`, or are a JSON array after `json:`.
        kind: bool, int, float, str, Status, an Enum, `list[...]` of them, dict, or Any, which changes nothing.
        enums: Numbers by name; int, float and Enum ports also accept these names.

    Raises:
        TreeError: The text cannot be converted.
    """
    enums = enums or _NO_ENUMS
    if kind is Any or kind is str:
        return text
    if kind is bool:
        return _looked_up(text, TRUTH, "true or false")
    if kind is int:
        return enums[text] if text in enums else int(_matched(text, _INTEGER, "a whole number"))
    if kind is float:
        return float(enums[text]) if text in enums else float(_matched(text, _REAL, "a number"))
    if get_origin(kind) is list or kind in (list, dict):
        return _many(text, kind, enums)
    if kind is Status:
        return outcome_named(text) if not _INTEGER.fullmatch(text) else _outcome(int(text))
    if isinstance(kind, type) and issubclass(kind, Enum):
        return _member(text, kind, enums)
    raise TreeError(
        Fault(f"{text!r} cannot be converted to {kind}: only the blackboard holds such values, never a file.")
    )


def to_string(value: Any) -> str:
    """Text of a value as BehaviorTree.CPP writes it: integers as usual, other numbers with six decimals."""
    if isinstance(value, bool):
        return str(int(value))
    return f"{value:.6f}" if isinstance(value, float) else str(value)


def plain(value: Any) -> Any:
    """A number of numpy, or of a class derived from a number, as Python's own; every other value unchanged."""
    if value.__class__ in (bool, int, float, str) or isinstance(value, Enum):
        return value
    for kind in (float, int):
        if isinstance(value, kind):
            return kind(value)
    return value.item() if getattr(value, "shape", None) == () else value


def type_name(kind: Any) -> str:
    """Name of a type in messages."""
    return kind.__name__ if isinstance(kind, type) and not hasattr(kind, "__args__") else str(kind)


def numeric(value: Any) -> Any:
    """Number of an enum value or outcome, as scripts see it; every other value unchanged."""
    if value.__class__ is Status or value.__class__ is Skip:
        return STATUS_NAMES.index(outcome_name(value))
    return value.value if isinstance(value, Enum) and isinstance(value.value, (int, float)) else value


def _unfit(value: Any, kind: Any, why: str = "") -> TreeError:
    return TreeError(Fault(f"{value!r} ({type_name(type(value))}) is not a value of type {type_name(kind)}{why}."))


def _plain_number(value: Any) -> Any:
    """Number of a number, truth value or enum value; None for other values."""
    number = numeric(plain(value))
    return number if number.__class__ in (bool, int, float) else None


def _number(value: Any, kind: type[Any]) -> Any:
    number = _plain_number(value)
    if number is None:
        raise _unfit(value, kind)
    if kind is float:
        try:
            return float(number)
        except OverflowError:
            raise _unfit(value, kind, ": it is too large") from None
    if kind is bool:
        # As in BehaviorTree.CPP an int is 0 or 1, every float above 0.0 is true, and negative numbers are refused.
        if number < 0 or (number.__class__ is int and number > 1):
            raise _unfit(value, kind, ": write 0 or 1")
        return bool(number)
    if number.__class__ is float and not number.is_integer():
        raise _unfit(value, kind)
    return int(number)


def _text(value: Any) -> str:
    if value.__class__ is Status or value.__class__ is Skip:
        return outcome_name(value)
    if isinstance(value, Enum):
        return value.name
    number = plain(value)
    if number.__class__ in (str, bool, int, float):
        return to_string(number)
    raise _unfit(value, str)


def _items(value: Any, kind: Any, enums: Enums) -> Any:
    """A list with items of the list's type: the same list if they have it already."""
    (item,) = get_args(kind)
    if not isinstance(value, Iterable) or isinstance(value, (Mapping, set, frozenset)):
        if _plain_number(value) is None:
            raise _unfit(value, kind)
        value = [value]  # an attribute of a subtree such as q="5" is a number
    found = [converted(each, item, enums) for each in value]
    same = value.__class__ is list and all(a is b for a, b in zip(found, value, strict=True))
    return value if same else found


def _outcome(value: Any) -> Any:
    if value.__class__ is Skip:
        return value
    number = None if isinstance(value, Enum) else _plain_number(value)
    if number is None or number not in range(len(STATUS_NAMES)):
        raise _unfit(value, Status, f"; the numbers are 0 to 4 for {', '.join(STATUS_NAMES)}")
    return outcome_named(STATUS_NAMES[int(number)])


def _numbered(number: float, kind: type[Enum]) -> Enum:
    for member in kind:
        if member.value == number:
            return member
    raise _unfit(number, kind, f"; the values are {', '.join(f'{m.name} = {m.value}' for m in kind)}")


def _many(text: str, kind: Any, enums: Enums) -> Any:
    """List or dict of a text."""
    if not text.startswith(_JSON):
        if get_origin(kind) is not list:
            message = f"{text!r} cannot be converted to {type_name(kind)}."
            raise TreeError(Fault(message, hint=f"Write it as JSON after '{_JSON}'."))
        (item,) = get_args(kind)
        return [from_string(part, item, enums) for part in text.split(";")] if text else []
    try:
        found = json.loads(text[len(_JSON) :])
    except ValueError as error:
        raise TreeError(Fault(f"{text!r} cannot be read as JSON: {error}.")) from None
    if not isinstance(found, get_origin(kind) or kind):
        raise _unfit(found, kind)
    return converted(found, kind, enums)


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
