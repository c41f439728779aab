"""A JSON document whose lists of nodes and edges know where each of their elements stands."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from typing import Any, NoReturn

from ...nesting import LIMIT, too_deep

_SPACE = re.compile(r"[ \t\r\n]*")


class Scanner:
    """Reads one JSON object; of some of its keys the list's elements one by one, with their offsets in the text.

    Attributes:
        values: What each key holds; for a list that was taken apart, pairs of an offset and an element.
    """

    def __init__(self, text: str, apart: frozenset[str]) -> None:
        self._text = text
        self._decode = json.JSONDecoder(object_pairs_hook=_once, parse_constant=_refuse).raw_decode
        self.values: dict[str, Any] = {}
        if too_deep(text):
            raise json.JSONDecodeError(f"Lists and objects nest more than {LIMIT} deep", text, 0)
        at = self._each(self._past(0, "{"), "}", lambda at: self._pair(at, apart))
        if self._skip(at) != len(text):
            self._wrong("nothing more", at)

    def _pair(self, at: int, apart: frozenset[str]) -> int:
        key, end = self._value(at)
        if not isinstance(key, str):
            self._wrong("a key in quotes", at)
        if key in self.values:
            self._wrong(f"no second '{key}'", at)
        end = self._skip(self._past(end, ":"))
        if key not in apart:
            self.values[key], end = self._value(end)
            return end
        found = self.values[key] = []

        def element(at: int) -> int:
            value, end = self._value(at)
            found.append((at, value))
            return end

        return self._each(self._past(end, "["), "]", element)

    def _each(self, at: int, close: str, take: Callable[[int], int]) -> int:
        at = self._skip(at)
        if self._text.startswith(close, at):
            return at + 1
        while True:
            at = self._skip(take(self._skip(at)))
            if self._text.startswith(close, at):
                return at + 1
            at = self._past(at, ",")

    def _value(self, at: int) -> tuple[Any, int]:
        try:
            return self._decode(self._text, at)
        except json.JSONDecodeError:
            raise
        except ValueError as error:  # too many digits, NaN, a key twice
            raise json.JSONDecodeError(str(error), self._text, at) from error

    def _past(self, at: int, mark: str) -> int:
        at = self._skip(at)
        if not self._text.startswith(mark, at):
            self._wrong(f"'{mark}'", at)
        return at + 1

    def _skip(self, at: int) -> int:
        match = _SPACE.match(self._text, at)
        return at if match is None else match.end()

    def _wrong(self, wanted: str, at: int) -> NoReturn:
        raise json.JSONDecodeError(f"Expecting {wanted}", self._text, self._skip(at))


def place_of(text: str, offset: int) -> tuple[int, int]:
    """Line and column of an offset, both from 1."""
    return text.count("\n", 0, offset) + 1, offset - text.rfind("\n", 0, offset)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        twice = next(name for name in found if sum(name == other for other, _ in pairs) > 1)
        raise ValueError(f"'{twice}' stands twice in one object")
    return found


def _refuse(name: str) -> NoReturn:
    raise ValueError(f'{name} is no JSON; write {{"float": "inf"}}')
