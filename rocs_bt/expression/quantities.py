"""Preprocessor of expressions: replaces units and keywords that Python's grammar does not have.

Units, as in `0.5 m`, are replaced by blanks, so that columns in the text that Python parses equal those in the original
text. Each unit is stored by the column of its number. The keywords of requirements are replaced by Python operators
with the right precedence, and their columns are stored: `a implies b` is parsed as `a or b`, `within 0.2 s a` as
`not a`.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from ..base.errors import Fault, InputError, did_you_mean
from ..base.units import NONE, Quantity, parse_unit, unit_names

_NUMBER = re.compile(r"(?<![\w.])(?:inf\b|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)")
_WORD = re.compile(r"(\s*)([A-Za-z_]\w*)")
# `min` before a bracket is the function, not the unit, as in `1 m/min(front)`.
_NAME = r"(?!min\s*\()([A-Za-z]+)(?:\^-?\d|\d)?(?!\w)"
_UNIT = re.compile(_NAME)
_PERCENT = re.compile(r"\s*%")
_UNIT_PART = re.compile(rf"[*/]{_NAME}")
_ALWAYS = re.compile(r"\s*always\b")
_IMPLIES = re.compile(r"\bimplies\b")
_WITHIN = re.compile(r"\bwithin\s+((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[A-Za-z_]\w*)(?=\s)")
_ALLOWED = re.compile(r"[^A-Za-z0-9_ .,+\-*/<>=!()\[\]:^%]")
_QUOTED = re.compile(r"""(["'])(.*?)\1""", re.DOTALL)


@dataclass(frozen=True)
class Folded:
    """Preprocessed text of an expression, with the units and keywords that were replaced.

    Attributes:
        text: Text for Python's parser, as long as the original.
        units: Unit of each number, by the column of the number's first character, counted from 0.
        ends: Column at which each unit ends, by the column at which its number ends, counted from 0.
        implies: Columns of `implies`, which is replaced by `or`, counted from 0.
        within: Window of each `within`, which is replaced by `not`, by its column, counted from 0.
        always: Whether the original text begins with `always`.
    """

    text: str
    units: dict[int, Quantity]
    ends: dict[int, int]
    implies: frozenset[int] = frozenset()
    within: Mapping[int, Quantity | str] = field(default_factory=dict)
    always: bool = False


def blank_texts(text: str) -> str:
    """Replace the characters of quoted texts by `_`, so that they are not parsed."""
    return _QUOTED.sub(lambda found: found[1] + "_" * len(found[2]) + found[1], text)


def fold_quantities(text: str, texts: bool = False) -> Folded:
    """Preprocess the text of an expression: replace units by blanks, and keywords by Python operators.

    If `texts`, quoted texts are allowed; their characters are replaced by `_`.

    Raises:
        InputError: The text has an invalid character, or a word after a number is not a unit.
    """
    if texts:
        text = blank_texts(text)
    text = text.replace("\n", " ").replace("\t", " ")
    if invalid := _ALLOWED.search(_QUOTED.sub(lambda found: " " * len(found[0]), text) if texts else text):
        message = f"invalid character {invalid[0]!r} in an expression."
        raise InputError(Fault(message, column=invalid.start() + 1))
    units: dict[int, Quantity] = {}
    ends: dict[int, int] = {}
    for number in list(_NUMBER.finditer(text)):
        end = _unit_end(text, number.end())
        if end is None:
            continue
        ends[number.end()] = end
        units[number.start()] = parse_unit(text[number.end() : end])
        text = text[: number.end()] + " " * (end - number.end()) + text[end:]
    for mark in "^%":
        if mark in text:
            raise InputError(Fault(f"invalid character {mark!r} in an expression.", column=text.index(mark) + 1))
    always = False
    if word := _ALWAYS.match(text):
        text, always = " " * word.end() + text[word.end() :], True
    implies = frozenset(word.start() for word in _IMPLIES.finditer(text))
    text = _IMPLIES.sub("or     ", text)
    within = {word.start(): _window(word, units) for word in _WITHIN.finditer(text)}
    text = _WITHIN.sub(lambda word: "not".ljust(len(word[0])), text)
    return Folded(text, units, ends, implies, within, always)


def _window(word: re.Match[str], units: Mapping[int, Quantity]) -> Quantity | str:
    """Window of a `within`: a quantity, or the name of a threshold."""
    if word[1][0].isalpha() or word[1][0] == "_":
        return word[1]
    unit = units.get(word.start(1), Quantity(1.0, NONE))
    return Quantity(float(word[1]) * unit.value, unit.dimension)


def _unit_end(text: str, at: int) -> int | None:
    """Column at which the unit after a number ends; None if the number has no unit."""
    if percent := _PERCENT.match(text, at):
        return percent.end()
    word = _WORD.match(text, at)
    if word is None:
        return None
    called = text[word.end() :].lstrip().startswith("(")
    if word[1] and (keyword.iskeyword(word[2]) or word[2] == "implies" or (called and word[2] == "min")):
        return None
    unit = _UNIT.match(text, word.start(2))
    if unit is None or unit[1] not in unit_names():
        message = f"'{word[2]}' after a number is not a unit."
        raise InputError(Fault(message, column=word.start(2) + 1, hint=did_you_mean(word[2], unit_names(), "The list")))
    end = unit.end()
    while (part := _UNIT_PART.match(text, end)) and part[1] in unit_names():
        end = part.end()
    return end
