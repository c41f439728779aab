"""Paths to fields of messages, such as `pose.pose.position.x`, `ranges` or `velocity[0]`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from ...base.errors import DeviceError, Fault, InputError, unknown
from .message_types import MessageTypes

_STEP = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)((?:\[\d+\])*)\Z")


class FieldPath:
    """Path to a field of a message.

    Args:
        text: Names of nested fields, separated by dots, each with indices for elements of arrays: `status[0].level`.

    Raises:
        InputError: The text is no path.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self.steps: list[str | int] = []
        for part in text.split("."):
            found = _STEP.match(part.strip())
            if found is None:
                raise InputError(Fault(f"'{text}' is no path to a field.", hint="Write 'a.b' or 'c[0]'."))
            self.steps += [found[1], *map(int, re.findall(r"\d+", found[2]))]

    def __str__(self) -> str:
        return self.text

    def check(self, types: MessageTypes, name: str) -> Any:
        """Check that messages of a type have this field; returns rosbags' description of its type.

        Raises:
            InputError: The type is unknown, or has no such field.
        """
        of: Any = None
        owner = name
        for step in self.steps:
            if isinstance(step, int):
                if of[0].name not in ("ARRAY", "SEQUENCE"):
                    raise InputError(Fault(f"'{self.text}': the field before [{step}] is no array."))
                of = of[1][0]
                continue
            if of is not None and of[0].name != "NAME":
                raise InputError(Fault(f"'{self.text}': the field before '.{step}' has no fields."))
            owner = name if of is None else of[1]
            fields = types.fields(owner)
            if step not in fields:
                raise InputError(unknown("field", step, fields, f"'{owner}'"))
            of = fields[step]
        return of

    def size(self, types: MessageTypes, name: str) -> int | None:
        """Number of values of the field in messages of a type; None for an array of variable length.

        Raises:
            InputError: See `check`.
        """
        kind, detail = self.check(types, name)
        if kind.name == "ARRAY":
            return int(detail[1])
        return None if kind.name == "SEQUENCE" else 1

    def get(self, message: Any) -> Any:
        """Value of the field.

        Raises:
            DeviceError: An array of the message is too short.
        """
        found = message
        for step in self.steps:
            if isinstance(step, str):
                found = getattr(found, step)
            elif step < len(found):
                found = found[step]
            else:
                raise DeviceError(f"'{self.text}': the array has {len(found)} elements")
        return found

    def numbers(self, message: Any) -> Sequence[float]:
        """Values of the field as numbers: one, or those of an array.

        Raises:
            DeviceError: An array of the message is too short, or the field has no numbers.
        """
        found = self.get(message)
        try:
            return (
                list(map(float, found)) if hasattr(found, "__len__") and not isinstance(found, str) else [float(found)]
            )
        except (TypeError, ValueError) as error:
            raise DeviceError(f"'{self.text}' has no numbers, found {found!r:.40}") from error
