"""Values of the graph as they stand in a file: in SQLite, in JSON, and back to what the schema says they are."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any, TypeAlias

from ...event import Value, pack, unpack
from ...geometry import Pose2
from ...nesting import check_nesting
from ..attribute import Attribute

Stored: TypeAlias = float | int | str | bytes | None
_INT64 = 1 << 63
_NUMBERS, _JSON = b"v", b"j"  # what a blob begins with


def to_sql(value: Value) -> Stored:
    """A value, or a name, as SQLite keeps it: itself where SQLite has it to the bit, else a blob.

    A blob is `v` and packed float64 (poses and lists of numbers), or `j` and the JSON of `to_json` (True and False,
    whole numbers beyond 64 bits, NaN, texts that are no Unicode).
    """
    kind = type(value)
    if kind is float and value == value:
        return value  # type: ignore[return-value]  # mypy does not narrow by the type itself
    if isinstance(value, str):
        return value if value.isascii() or _is_unicode(value) else _JSON + dump(to_json(value))
    if value is None or (kind is int and -_INT64 <= value < _INT64):  # type: ignore[operator]  # an int, by its kind
        return value  # type: ignore[return-value]  # None, or that int
    if isinstance(value, list) and all(type(v) is float for v in value):
        return _NUMBERS + pack(value)
    return _JSON + dump(to_json(value))


def from_sql(stored: Stored) -> Value:
    """The value that `to_sql` kept.

    Raises:
        ValueError: It is none of ours.
    """
    if type(stored) is not bytes:
        return stored  # type: ignore[return-value]  # SQLite gives back the types that it took
    kind, data = stored[:1], stored[1:]
    if kind == _NUMBERS and len(data) % 8 == 0:
        return unpack(data)
    if kind == _JSON:
        check_nesting(data)
        return from_json(json.loads(data))
    raise ValueError(f"a value begins with {stored[:8]!r}")


def row_to_sql(attributes: Mapping[str, Value]) -> bytes | None:
    """The attributes of an edge as one blob; None where it has none."""
    return dump({name: to_json(value) for name, value in attributes.items()}) if attributes else None


def row_from_sql(stored: bytes | None) -> dict[str, Value]:
    """The attributes that `row_to_sql` kept.

    Raises:
        ValueError: They are none of ours.
    """
    if stored is None:
        return {}
    check_nesting(stored)
    found = json.loads(stored)
    if not isinstance(found, dict):
        raise ValueError(f"the attributes of an edge begin with {stored[:8]!r}")
    return {name: from_json(value) for name, value in found.items()}


def to_json(value: Any) -> Any:
    """A value as JSON has it; what JSON has not is an object with one key: `{"float": "inf"}`, `{"int": "0x..."}`."""
    if type(value) is float:
        return value if math.isfinite(value) else {"float": repr(value)}
    if type(value) is int and not -_INT64 <= value < _INT64:
        return {"int": hex(value)}  # decimal digits are limited, and read back as float elsewhere
    if isinstance(value, (list, tuple)):
        return [to_json(v) for v in value]
    return value


def from_json(value: Any) -> Value:
    """The value that `to_json` wrote.

    Raises:
        ValueError: It is none of ours.
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


def dump(value: Any) -> bytes:
    """JSON without spaces, in ASCII: the same value gives the same bytes."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).encode("ascii")


def typed(value: Value, declared: Attribute | None) -> Any:
    """A value as the graph holds it: a pose where the schema declares one, a tuple for any other list."""
    if isinstance(value, list):
        return Pose2(*value) if declared is not None and declared.type is Pose2 and len(value) == 3 else tuple(value)
    return value


def plain(value: Any) -> Value:
    """A value of the graph as its events tell it."""
    return list(value) if isinstance(value, tuple) else value


def _is_unicode(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:  # half of a surrogate pair, which Python can hold
        return False
    return True
