"""Messages of ROS 2 from plain values, converted to the types of their fields."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from ...base.errors import Fault, InputError, unknown
from ...base.units import NONE, TIME, parse_quantity
from ..messages.field_path import field_at, primitive
from ..messages.fields import time_fields
from ..ros_link import FieldPath, RosField, RosTypes, index_path

_INTEGER = re.compile(r"(u?)int(8|16|32|64)")
_FLOATS = ("float32", "float64")
_TEXTS = ("string", "wstring")
_TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
_TRUTH = {"true": True, "True": True, "1": True, "false": False, "False": False, "0": False}
MAX_INDEX = 10_000
"""Maximum index in a field path that is written."""


def message(types: RosTypes, type: str, values: Iterable[tuple[FieldPath, Any]]) -> dict[str, Any]:
    """Create the plain values of a message.

    The value of an empty path is a mapping with several fields.

    Raises:
        InputError: A field is unknown, or a value does not fit its field.
    """
    found: dict[str, Any] = {}
    for path, value in values:
        field = field_at(types, type, path)
        made = value if field is None else converted(types, field, value, index_path(path) or "the message")
        if path:
            _put(types, type, found, path, made)
        else:
            found.update(made)
    return found


def converted(types: RosTypes, field: RosField, value: Any, what: str) -> Any:
    """Convert a value to the type of a field.

    Args:
        types: Known types.
        field: Type of the field.
        value: Number, text, sequence, or mapping of the fields of a nested message. A text may be a quantity such as
            `0.2 m/s`, which becomes a number in SI units.
        what: Name of the field, for messages.

    Raises:
        InputError: The value does not fit.
    """
    if field.array:
        if isinstance(value, (str, Mapping)) or not isinstance(value, Iterable):
            raise InputError(Fault(f"{what} is an array ({field}), found {value!r:.60}.", hint="Write [1, 2, 3]."))
        items = [converted(types, RosField(field.type), item, f"{what}[{i}]") for i, item in enumerate(value)]
        if field.size is not None and len(items) != field.size:
            raise InputError(Fault(f"{what} has {field.size} elements, found {len(items)}."))
        return items
    if not primitive(field):
        return _nested(types, field.type, value, what)
    if field.type in _TEXTS:
        return value if isinstance(value, str) else str(value)
    try:
        return _number(field.type, value)
    except (InputError, ValueError, OverflowError, TypeError) as error:
        reason = error.faults[0].message if isinstance(error, InputError) else ""
        raise InputError(Fault(f"{what} is of type {field}, found {value!r:.60}. {reason}".rstrip())) from error


def _nested(types: RosTypes, type: str, value: Any, what: str) -> dict[str, Any]:
    if isinstance(value, Mapping):
        fields, made = types.fields(type), {}
        for name, item in value.items():
            if fields is not None and name not in fields:
                raise InputError(unknown("field", name, fields, f"'{type}'"))
            inner = name if what == "the message" else f"{what}.{name}"
            made[name] = item if fields is None else converted(types, fields[name], item, inner)
        return made
    if type in _TIMES and isinstance(value, (str, int, float)) and not isinstance(value, bool):
        quantity = parse_quantity(value) if isinstance(value, str) else None
        if quantity is None or quantity.dimension in (TIME, NONE):
            seconds = float(value) if quantity is None else quantity.value
            return time_fields(seconds)
    fields = types.fields(type)
    first = "" if not fields else f"Write {what}.{next(iter(fields))} = ..., for each field that you need."
    raise InputError(Fault(f"{what} is a message ({type}), found {value!r:.60}.", hint=first))


def seconds(value: Mapping[str, Any]) -> float:
    """Duration of the plain values of a builtin_interfaces/Duration [s]."""
    return float(value.get("sec", 0)) + 1e-9 * float(value.get("nanosec", 0))


def _number(type: str, value: Any) -> bool | int | float:
    """Convert a number, or a text with a number or a quantity, to a primitive type."""
    if type == "bool":
        if isinstance(value, str):
            return _TRUTH[value] if value in _TRUTH else _raise("Write true or false.")
        return bool(value) if value in (0, 1) else _raise("Write true or false.")
    if isinstance(value, str):
        value = int(value) if re.fullmatch(r"[+-]?[0-9]+", value) else parse_quantity(value).value
    if type in _FLOATS:
        return float(value)
    match = _INTEGER.fullmatch(type)
    unsigned, bits = (True, 8) if match is None else (bool(match[1]), int(match[2]))  # byte, char, octet
    whole = int(value)
    low, high = (0, 2**bits - 1) if unsigned else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    if whole != value or not low <= whole <= high:
        _raise(f"It must be a whole number from {low} to {high}.")
    return whole


def _raise(reason: str) -> Any:
    raise InputError(Fault(reason))


def _put(types: RosTypes, type: str, found: dict[str, Any], path: FieldPath, value: Any) -> None:
    """Put a value at a path; arrays on the path grow, with default values in between."""
    target: Any = found
    for at, part in enumerate(path):
        if isinstance(part, int):
            _grow(types, type, target, path[:at], part)
        if at == len(path) - 1:
            target[part] = value
        elif isinstance(part, int):
            target = target[part]
        else:
            target = target.setdefault(part, [] if isinstance(path[at + 1], int) else {})


def _grow(types: RosTypes, type: str, target: list[Any], path: FieldPath, index: int) -> None:
    if index > MAX_INDEX:
        raise InputError(Fault(f"the index {index} of '{index_path(path)}' is too large; the maximum is {MAX_INDEX}."))
    field = field_at(types, type, path) or RosField("")
    while len(target) < max(index + 1, field.size or 0):
        target.append(
            {} if not primitive(field) else "" if field.type in _TEXTS else False if field.type == "bool" else 0
        )
