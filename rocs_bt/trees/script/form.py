"""Parsed scripts. Scripts that differ only in names and literals share one syntax tree, which is parsed once."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ...base.errors import InputError
from .parser import (
    MAX_DIGITS,
    MAX_LENGTH,
    Assignment,
    Expression,
    Literal,
    Name,
    number_of,
    parse_statements,
    parts,
    walk,
)


def leaves(statements: tuple[Expression, ...]) -> Iterator[Name | Literal]:
    """Names and literals of statements, in the order of the text; each one is a slot of the `Form`."""
    return (e for s in statements for e in walk(s) if isinstance(e, Name | Literal))


_SLOT = re.compile(  # strings, numbers and names of the lexer
    r"""('[^']*'|"[^"]*")|(0[xX][0-9a-fA-F]+|\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)|([^\W\d]\w*|@\w*)"""
)
_TRUTHS = {"true": 1, "false": 0}
_SAMPLES = {"N": "n", "I": "1", "F": "1.5", "S": "''", "T": "true"}


@dataclass(frozen=True, eq=False)
class Form:
    """Syntax tree shared by all scripts that differ only in names and literals."""

    statements: tuple[Expression, ...]


class Script:
    """Parsed script of BehaviorTree.CPP's scripting language.

    Args:
        text: Text of the script.
        statements: Statements; by default parsed from the text on first access.
        form: Syntax tree shared with similar scripts; None if it is not shared.
        slots: Names and literals of this script, which replace the placeholders of `form`, in the order of the text.
    """

    __slots__ = ("_statements", "form", "slots", "text")

    def __init__(
        self,
        text: str,
        statements: tuple[Expression, ...] | None = None,
        form: Form | None = None,
        slots: tuple[Any, ...] = (),
    ) -> None:
        self.text = text
        self.form = form
        self.slots = slots
        self._statements = statements
        if form is None and statements is not None:
            self.slots = tuple(leaf.name if isinstance(leaf, Name) else leaf.value for leaf in leaves(statements))

    @property
    def statements(self) -> tuple[Expression, ...]:
        """Statements in order; the value of the last one is the value of the script."""
        if self._statements is None:
            self._statements = parse_statements(self.text)
        return self._statements

    def reads(self) -> list[Name]:
        """Names that the script reads, in the order of the text; `x += 1` reads `x`."""
        return [e for s in self.statements for e in _reads(s)]

    def writes(self) -> list[Assignment]:
        """Assignments in the order of the text."""
        return [e for s in self.statements for e in walk(s) if isinstance(e, Assignment)]


@functools.lru_cache(maxsize=16_384)  # a script is parsed when it is checked and when its node is made
def parse_script(text: str) -> Script:
    """Parse a script.

    Args:
        text: Statements such as `battery := 0.9; tries += 1`, optionally separated by `;`.

    Raises:
        ScriptError: The text is not a valid script; the error contains the position.
    """
    form, slots = _outline(text)
    return Script(text, None if form is not None else parse_statements(text), form, slots)


def _outline(text: str) -> tuple[Form | None, tuple[Any, ...]]:
    """Split a script into its shared form, and its names and literals, without parsing it.

    Returns:
        Form, or None if the text can only be split by the parser; and the names and literals.
    """
    pieces = _SLOT.split(text)  # text, string, number, name, text ...
    between = tuple(pieces[::4])
    if len(text) > MAX_LENGTH or "" in between[1:-1]:
        return None, ()
    kinds, slots = "", list[Any]()
    for at in range(3, len(pieces), 4):
        if (name := pieces[at]) is not None:
            truth = name in _TRUTHS
            kinds += "T" if truth else "N"
            slots.append(_TRUTHS[name] if truth else name)
        elif (number := pieces[at - 1]) is not None:
            if len(number) > MAX_DIGITS:
                return None, ()
            value = number_of(number)
            kinds += "I" if value.__class__ is int else "F"
            slots.append(value)
        else:
            kinds += "S"
            slots.append(pieces[at - 2][1:-1])
    form = _form(between, kinds) if "@" not in slots else None
    return form, tuple(slots)


@functools.lru_cache(maxsize=1024)
def _form(between: tuple[str, ...], kinds: str) -> Form | None:
    """Create the form of all scripts with these operators and kinds of names and literals; None if they are invalid.

    Args:
        between: Texts before, between and after the slots: operators and spaces.
        kinds: One letter for each slot: N name, I integer, F other number, S string, T `true` or `false`.
    """
    samples = [*(_SAMPLES[kind] for kind in kinds), ""]
    try:
        return Form(parse_statements("".join(b + s for b, s in zip(between, samples, strict=True))))
    except InputError:
        return None


def _reads(expression: Expression) -> Iterator[Name]:
    if isinstance(expression, Name):
        yield expression
    elif isinstance(expression, Assignment):
        if expression.operator not in (":=", "="):
            yield expression.target
        yield from _reads(expression.value)
    else:
        for part in parts(expression):
            yield from _reads(part)
