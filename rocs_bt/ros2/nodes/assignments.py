"""Ports with fields of ROS 2 messages: `linear.x = 0.2 m/s; angular.z = {turn}`, and `pose.position.x -> {x}`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, NoReturn

from ...base.errors import Fault, InputError
from ...trees.nodes import KeyUse, Syntax
from ...trees.script import ScriptError
from ..messages.field_path import parse_path
from ..ros_link import FieldPath

_KEY = re.compile(r"\{\s*(@?[^{}\s@]+)\s*\}")
_QUOTES = "'\""
_OUTPUT_HINT = "Write fields as in: pose.position.x -> {x}; . -> {message}."
_HINT = "Write fields as in: linear.x = 0.2; frame_id = 'map'; ranges = [1, 2]; angular.z = {key}."


class Key(NamedTuple):
    """Blackboard key in the text of a port.

    Attributes:
        name: Name of the key.
        column: Position in the text, counted from 0.
    """

    name: str
    column: int


@dataclass(frozen=True)
class FieldInput:
    """Field of a message and the value to write to it.

    Attributes:
        path: Path of the field; empty for a mapping of several fields.
        value: Text, number, list or mapping; keys in it are instances of `Key`.
        column: Position in the text of the port, counted from 0.
    """

    path: FieldPath
    value: Any
    column: int = 0

    def current(self, read: Callable[[str], Any]) -> Any:
        """Value with the keys replaced by their values."""
        return _resolved(self.value, read)

    @property
    def constant(self) -> bool:
        """Whether the value contains no key."""
        return not list(_keys(self.value))


@dataclass(frozen=True)
class FieldOutput:
    """Field of a message and the blackboard key that gets its value.

    Attributes:
        path: Path of the field; empty for the whole message.
        key: The key.
        column: Position in the text of the port, counted from 0.
    """

    path: FieldPath
    key: Key
    column: int = 0


def inputs_of(value: Any) -> tuple[FieldInput, ...]:
    """Assignments that the value of a FieldInputs port describes.

    Args:
        value: Parsed assignments, their text, or a mapping of paths to values.

    Raises:
        InputError: The value is none of these, or the text is faulty.
    """
    if isinstance(value, str):
        return parse_inputs(value)
    if isinstance(value, Mapping):
        return tuple(FieldInput(parse_path(path), item) for path, item in value.items())
    if isinstance(value, tuple) and all(isinstance(item, FieldInput) for item in value):
        return value
    raise InputError(Fault(f"{value!r:.60} does not describe the fields of a message.", hint=_HINT))


def parse_inputs(text: str) -> tuple[FieldInput, ...]:
    """Parse `path = value; path = value`.

    Raises:
        ScriptError: The text is faulty; the error has the position.
    """
    return tuple(_Parser(text).inputs())


def parse_outputs(text: str) -> tuple[FieldOutput, ...]:
    """Parse `path -> {key}; path -> {key}`; see `parse_inputs`."""
    return tuple(_Parser(text).outputs())


def _keys_read(text: str) -> Iterator[KeyUse]:
    for item in parse_inputs(text):
        yield from (KeyUse(key.name, key.column, writes=False) for key in _keys(item.value))


def _keys_written(text: str) -> Iterator[KeyUse]:
    return (KeyUse(item.key.name, item.key.column, writes=True) for item in parse_outputs(text))


FieldInputs = Annotated[Any, Syntax(parse_inputs, _keys_read)]
"""Port with values of the fields of a message: `path = value`, separated by `;`.

A value is a number, a quantity, `true`, a text with or without quotes, `{key}`, or a list of these in brackets. The
port may also be one key that holds a mapping of the fields, or in Python a mapping of paths to values.
"""

FieldOutputs = Annotated[Any, Syntax(parse_outputs, _keys_written)]
"""Port with blackboard keys for the fields of a message: `path -> {key}`, separated by `;`.

The path `.` means the whole message, as a mapping.
"""


class _Parser:
    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0

    def inputs(self) -> Iterator[FieldInput]:
        for start, path in self.paths("="):
            self.space()
            value = self.value(";")
            yield FieldInput(path, value, start)
            self.end_of_item()

    def outputs(self) -> Iterator[FieldOutput]:
        for start, path in self.paths("->"):
            self.space()
            yield FieldOutput(path, self.key(), start)
            self.end_of_item()

    def paths(self, sign: str) -> Iterator[tuple[int, FieldPath]]:
        """Paths with their positions; stops behind the sign that follows each path."""
        while True:
            self.space(";")
            if self.at >= len(self.text):
                return
            start = self.at
            end = self.text.find(sign, start)
            stop = self.text.find(";", start)
            if end < 0 or 0 <= stop < end:
                item = self.text[start : len(self.text) if stop < 0 else stop].strip()
                form = "path = value" if sign == "=" else "path -> {key}"
                self.fail(start, f"expected '{form}', found '{item}'.", _HINT if sign == "=" else _OUTPUT_HINT)
            try:
                path = parse_path(self.text[start:end])
            except InputError as error:
                raise ScriptError(self.text, start, *error.faults) from error
            self.at = end + len(sign)
            yield start, path

    def value(self, ends: str) -> Any:
        """Value at the position; unquoted texts end before one of the characters `ends`."""
        if self.at >= len(self.text) or self.text[self.at] in ends:
            self.fail(self.at, "a value is missing.", _HINT)
        first = self.text[self.at]
        if first == "[":
            return self.list()
        if first in _QUOTES:
            return self.quoted(first)
        if first == "{":
            return self.key()
        start = self.at
        while self.at < len(self.text) and self.text[self.at] not in ends:
            self.at += 1
        return self.text[start : self.at].strip()

    def list(self) -> list[Any]:
        start, found = self.at, list[Any]()
        self.at += 1
        while True:
            self.space()
            if self.at < len(self.text) and self.text[self.at] == "]":
                self.at += 1
                return found
            found.append(self.value(",];"))
            self.space()
            if self.at < len(self.text) and self.text[self.at] == ",":
                self.at += 1
            elif self.at >= len(self.text) or self.text[self.at] != "]":
                self.fail(start, "the list has no ']'.", _HINT)

    def quoted(self, quote: str) -> str:
        start = self.at
        end = self.text.find(quote, start + 1)
        if end < 0:
            self.fail(start, f"the text has no second {quote}.", _HINT)
        self.at = end + 1
        return self.text[start + 1 : end]

    def key(self) -> Key:
        match = _KEY.match(self.text, self.at)
        if match is None:
            self.fail(self.at, f"expected a key such as {{x}}, found '{self.text[self.at :]:.30}'.", _OUTPUT_HINT)
        found = Key(match[1], self.at)
        self.at = match.end()
        return found

    def end_of_item(self) -> None:
        self.space()
        if self.at < len(self.text) and self.text[self.at] != ";":
            self.fail(self.at, f"expected ';', found '{self.text[self.at :]:.30}'.", "Separate fields by ';'.")

    def space(self, also: str = "") -> None:
        while self.at < len(self.text) and (self.text[self.at].isspace() or self.text[self.at] in also):
            self.at += 1

    def fail(self, at: int, message: str, hint: str) -> NoReturn:
        raise ScriptError(self.text, at, Fault(message, hint=hint))


def _keys(value: Any) -> Iterator[Key]:
    if isinstance(value, Key):
        yield value
    elif isinstance(value, list):
        for item in value:
            yield from _keys(item)


def _resolved(value: Any, read: Callable[[str], Any]) -> Any:
    if isinstance(value, Key):
        return read(value.name)
    return [_resolved(item, read) for item in value] if isinstance(value, list) else value
