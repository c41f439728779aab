"""Lossless conversion of graph values to JSON and back to the types that the schema declares."""

from __future__ import annotations

import json
import math
from typing import Any

from ...base.geometry import Pose2
from ...base.nesting import LIMIT, check_nesting
from ...event import Value
from ..attribute import Attribute

_INT64 = 1 << 63
_ENCODE = json.JSONEncoder(separators=(",", ":"), allow_nan=False).encode


def to_json(value: Any) -> Any:
    """Encode a value for JSON; infinities, NaN and large integers become objects, such as `{"float": "inf"}`."""
    if type(value) is float:
        return value if math.isfinite(value) else {"float": repr(value)}
    if type(value) is int and not -_INT64 <= value < _INT64:
        return {"int": hex(value)}  # decimal digits are limited, and read back as float elsewhere
    if isinstance(value, (list, tuple)):
        return [to_json(v) for v in value]
    return value


def from_json(value: Any) -> Value:
    """Decode a value that `to_json` encoded.

    Raises:
        ValueError: An object that `to_json` does not write.
    """
    if isinstance(value, list):
        return [from_json(v) for v in value]  # type: ignore[misc]  # lists in JSON are of numbers here
    if not isinstance(value, dict):
        return value  # type: ignore[no-any-return]  # a JSON value, checked by the schema later
    match value:
        case {"float": "inf" | "-inf" | "nan" as text} if len(value) == 1:
            return float(text)
        case {"int": str(text)} if len(value) == 1 and len(text) <= 4096:
            return int(text, 16)
    raise ValueError(f'an object must be {{"float": "inf"}} or {{"int": "0x..."}}, found the keys {list(value)[:3]}')


def dump(value: Any) -> str:
    """Compact ASCII JSON; equal values give equal texts."""
    return _ENCODE(value)


def load(text: str) -> Any:
    """Parse a JSON text.

    Raises:
        ValueError: It is not JSON, or nested too deeply.
    """
    if len(text) > LIMIT:
        check_nesting(text)
    return json.loads(text)


def typed(value: Value, declared: Attribute | None) -> Any:
    """A value in the type that the graph holds: a Pose2 if the schema declares one, a tuple for any other list."""
    if isinstance(value, list):
        return Pose2(*value) if declared is not None and declared.type is Pose2 and len(value) == 3 else tuple(value)
    return value


def plain(value: Any) -> Value:
    """A value of the graph in the form that events hold: a list for a tuple or a pose."""
    return list(value) if isinstance(value, tuple) else value
