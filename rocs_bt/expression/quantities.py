"""The small pre-tokeniser: it folds `0.5 m` and `60 deg`, which Python's grammar does not know.

The units are blanked out, so that every column of the text that Python parses is a column of the text that a person
wrote; what they were is kept by the column of their number.
"""

from __future__ import annotations

import keyword
import re
from dataclasses import dataclass

from ..errors import Fault, InputError, did_you_mean
from ..units import Quantity, parse_unit, unit_names

_NUMBER = re.compile(r"(?<![\w.])(?:inf\b|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)")
_WORD = re.compile(r"(\s*)([A-Za-z_]\w*)")
# Not before a bracket: there `min` is the function, as in `1 m/min(front)`.
_POWER = r"(?:\^-?\d|\d)?(?!\w|\s*\()"
_UNIT = re.compile(rf"([A-Za-z]+){_POWER}")
_UNIT_PART = re.compile(rf"[*/]([A-Za-z]+){_POWER}")
_ALLOWED = re.compile(r"[^A-Za-z0-9_ .,+\-*/<>=!()\[\]:^]")


@dataclass(frozen=True)
class Folded:
    """A text without its units.

    Attributes:
        text: As long as the text that was written, with blanks for units.
        units: The unit of the number that begins at a 0-based column.
        ends: Where the unit ends of the number that ends at a 0-based column.
    """

    text: str
    units: dict[int, Quantity]
    ends: dict[int, int]


def fold_quantities(text: str) -> Folded:
    """Blank the units out.

    Raises:
        InputError: A character that no expression has, or a word behind a number that is no unit.
    """
    text = text.replace("\n", " ").replace("\t", " ")
    if strange := _ALLOWED.search(text):
        message = f"an expression has no use for {strange[0]!r}."
        raise InputError(Fault(message, column=strange.start() + 1))
    units: dict[int, Quantity] = {}
    ends: dict[int, int] = {}
    for number in list(_NUMBER.finditer(text)):
        end = _unit_end(text, number.end())
        if end is None:
            continue
        ends[number.end()] = end
        units[number.start()] = parse_unit(text[number.end() : end])
        text = text[: number.end()] + " " * (end - number.end()) + text[end:]
    if "^" in text:
        raise InputError(Fault("an expression has no use for '^'.", column=text.index("^") + 1))
    return Folded(text, units, ends)


def _unit_end(text: str, at: int) -> int | None:
    """Where the unit behind a number ends; None where there is none."""
    word = _WORD.match(text, at)
    if word is None:
        return None
    if word[1] and (keyword.iskeyword(word[2]) or text[word.end() :].lstrip().startswith("(")):
        return None
    unit = _UNIT.match(text, word.start(2))
    if unit is None or unit[1] not in unit_names():
        message = f"'{word[2]}' behind a number is not a unit."
        raise InputError(Fault(message, column=word.start(2) + 1, hint=did_you_mean(word[2], unit_names(), "The list")))
    end = unit.end()
    while (part := _UNIT_PART.match(text, end)) and part[1] in unit_names():
        end = part.end()
    return end
