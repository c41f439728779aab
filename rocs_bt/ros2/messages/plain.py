"""Conversion between messages, of rosbags or of rclpy, and plain values: numbers, texts, lists and mappings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from ...base.errors import Fault, InputError
from ..network.rclpy_transport import message_class
from ..ros_link import FieldPath, RosField

_PRIMITIVES = {"boolean": "bool", "float": "float32", "double": "float64", "octet": "byte"}
_ARRAY = re.compile(r"sequence<(?P<element>[^,]+)(?:, ?\d+)?>|(?P<fixed>.+)\[(?P<size>\d+)\]")


class PlainMessage:
    """Received message of rosbags or of rclpy."""

    def __init__(self, message: Any) -> None:
        self._message = message

    def get(self, path: FieldPath = ()) -> Any:
        value = self._message
        for part in path:
            if isinstance(part, int):
                if part >= len(value):
                    raise LookupError(f"the array has {len(value)} elements")
                value = value[part]
            elif part not in names_of(value):
                raise LookupError(f"there is no field '{part}'")
            else:
                value = getattr(value, part)
        return plain(value)


def names_of(message: Any) -> list[str]:
    """Names of the fields of a message; empty for any other value."""
    if hasattr(message, "__msgtype__"):
        return [name for name in message.__dataclass_fields__ if not name.startswith("__")]
    if hasattr(message, "get_fields_and_field_types"):
        return list(message.get_fields_and_field_types())
    return []


def plain(value: Any) -> Any:
    """Convert a value of a message to a plain value."""
    if names := names_of(value):
        return {name: plain(getattr(value, name)) for name in names}
    if isinstance(value, (bytes, bytearray)):
        return value[0] if len(value) == 1 else list(value)
    if isinstance(value, (str, bool, int, float)):
        return value
    if hasattr(value, "tolist"):  # arrays of numpy and of the standard library
        return value.tolist()
    return [plain(item) for item in value] if isinstance(value, (list, tuple)) else {}


def filled(cls: Any, values: Mapping[str, Any]) -> Any:
    """Create a message of rclpy from plain values; other fields keep their defaults.

    Raises:
        InputError: A field is unknown, or a value does not fit it.
    """
    message, fields = cls(), rosidl_fields(cls)
    for name, value in values.items():
        if name not in fields:
            raise InputError(Fault(f"{cls.__name__} has no field '{name}'."))
        field = fields[name]
        try:
            setattr(message, name, _value(field, value))
        except (AssertionError, TypeError, ValueError, OverflowError) as error:
            reason = str(error).strip().splitlines()
            detail = f": {reason[0]}" if reason else ""
            raise InputError(
                Fault(f"{name} of {cls.__name__} is of type {field}, found {value!r:.60}{detail}")
            ) from error
    return message


def _value(field: RosField, value: Any) -> Any:
    if field.array:
        return [_value(RosField(field.type), item) for item in value]
    if "/" in field.type:
        return filled(message_class(field.type), value)
    return bytes([value]) if field.type == "byte" else value


def rosidl_fields(cls: Any) -> dict[str, RosField]:
    """Fields of a class that rosidl generated, by name."""
    return {name: _rosidl_field(text) for name, text in cls.get_fields_and_field_types().items()}


def _rosidl_field(text: str) -> RosField:
    match = _ARRAY.fullmatch(text)
    if match is None:
        return RosField(_rosidl_type(text))
    size = match["size"]
    return RosField(_rosidl_type(match["element"] or match["fixed"]), True, None if size is None else int(size))


def _rosidl_type(text: str) -> str:
    name = text.partition("<")[0]  # the bound of a text, as in string<10>
    return name.replace("/", "/msg/") if "/" in name else _PRIMITIVES.get(name, name)


def rosbags_fields(described: Mapping[str, Any]) -> dict[str, RosField]:
    """Fields of a message type as rosbags describes them, by name."""
    return {name: _rosbags_field(of) for name, of in described.items()}


def _rosbags_field(of: Any) -> RosField:
    kind, detail = of
    if kind.name == "NAME":
        return RosField(str(detail))
    if kind.name == "BASE":
        return RosField({"octet": "byte"}.get(detail[0], detail[0]))
    element, size = detail
    return RosField(_rosbags_field(element).type, True, size if kind.name == "ARRAY" else None)
