"""Paths to fields of messages, such as `pose.position.x` or `ranges[0]`: their text, type and value."""

from __future__ import annotations

import re
from typing import Any

from ...base.errors import DeviceError, Fault, InputError, unknown
from ..ros_link import FieldPath, RosField, RosTypes, index_path
from .plain import PlainMessage


def parse_path(text: str) -> FieldPath:
    """Parse a field path such as `poses[0].position.x`; `.` and an empty text mean the whole message.

    Raises:
        InputError: The text is not a path.
    """
    stripped = text.strip()
    if stripped in ("", "."):
        return ()
    if not re.fullmatch(r"[A-Za-z]\w*(\[[0-9]+\])?(\.[A-Za-z]\w*(\[[0-9]+\])?)*", stripped):
        hint = "Write names of fields, such as pose.position.x or ranges[0]."
        raise InputError(Fault(f"'{stripped}' is not the path of a field.", hint=hint))
    found: list[str | int] = []
    for name, index in re.findall(r"([A-Za-z]\w*)(?:\[([0-9]+)\])?", stripped):
        found.append(name)
        if index:
            found.append(int(index))
    return tuple(found)


def field_at(types: RosTypes, type: str, path: FieldPath) -> RosField | None:
    """Type of the field at a path; the empty path is the message itself.

    Returns:
        Field; None if a type on the path is not installed here.

    Raises:
        InputError: The type or a field is unknown, or an index does not fit.
    """
    found = RosField(type)
    for at, part in enumerate(path):
        here = index_path(path[:at])
        if isinstance(part, int):
            if not found.array:
                raise InputError(Fault(f"'{here}' is of type {found}, not an array.", hint="Remove the index."))
            if found.size is not None and part >= found.size:
                raise InputError(Fault(f"'{here}' has {found.size} elements; their indices begin at 0."))
            found = RosField(found.type)
            continue
        if found.array:
            raise InputError(Fault(f"'{here}' is an array ({found}).", hint=f"Write {here}[0].{part}."))
        if primitive(found):
            raise InputError(Fault(f"'{here}' is of type {found} and has no field '{part}'."))
        fields = types.fields(found.type)
        if fields is None:
            return None
        if part not in fields:
            raise InputError(unknown("field", part, fields, f"'{found.type}'"))
        found = fields[part]
    return found


def primitive(field: RosField) -> bool:
    """Whether the elements of a field are numbers or texts, not messages."""
    return "/" not in field.type


def numbers_at(message: Any, path: FieldPath) -> list[float]:
    """Values of the field of a message at a path, as numbers: one, or those of an array.

    Raises:
        DeviceError: An array of the message is too short, or the field has no numbers.
    """
    try:
        found = PlainMessage(message).get(path)
    except LookupError as error:
        raise DeviceError(f"'{index_path(path)}': {error}") from error
    try:
        return [float(each) for each in (found if isinstance(found, list) else [found])]
    except (TypeError, ValueError) as error:
        raise DeviceError(f"'{index_path(path)}' has no numbers, found {found!r:.40}") from error
