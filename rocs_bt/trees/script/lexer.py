"""A script's text as tokens."""

from __future__ import annotations

import re
from typing import NamedTuple

from ...errors import Fault
from .error import ScriptError

_TOKEN = re.compile(
    r"""
    (?P<space>(?:\s|\\\r?\n)+)
  | (?P<number>0[xX][0-9a-fA-F]+|\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)(?P<suffix>(?:\.(?!\.)|[A-Za-z_])?)
  | (?P<string>'[^']*'|"[^"]*")
  | (?P<name>[^\W\d]\w*|@\w*)
  | (?P<operator>:=|\+=|-=|\*=|/=|==|!=|<=|>=|&&|\|\||\.\.|[-+*/=<>&|^~!?:;()])
    """,
    re.VERBOSE,
)


class Token(NamedTuple):
    """A piece of a script.

    Attributes:
        kind: `number`, `string`, `name`, `operator` or `end`.
        text: As it stands.
        at: Where it begins, counted from 0.
    """

    kind: str
    text: str
    at: int


def tokens(text: str) -> list[Token]:
    """The tokens of a script, the last one of kind `end`.

    Raises:
        ScriptError: At what is no token.
    """
    found, at = [], 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            hint = "Strings end with the quote that they begin with." if text[at] in "'\"" else ""
            raise ScriptError(text, at, Fault(f"{text[at]!r} begins nothing that scripts know.", hint=hint))
        if match["suffix"]:
            hint = "Write 3.0 rather than 3., and begin names with a letter."
            raise ScriptError(text, at, Fault(f"{match['number'] + match['suffix']!r} is no number.", hint=hint))
        if match.lastgroup != "space":
            kind = "number" if match["number"] else str(match.lastgroup)
            found.append(Token(kind, match[0], at))
        at = match.end()
    return [*found, Token("end", "", len(text))]
