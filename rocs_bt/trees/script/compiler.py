"""From a parsed script to a Python function over one board. The code of a form is made once (see `writer`)."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from ...errors import Fault
from ..board import Board, Entry
from .arithmetic import (
    BITS,
    EPSILON,
    Refused,
    assign,
    assigned,
    chosen,
    compared,
    existing,
    folded,
    known,
    negated,
    quotient,
    real,
    truth,
)
from .form import Form, Script, Slots
from .parser import Expression, ScriptError, short
from .writer import write_statement

Run = Callable[[], Any]
_NONE = Entry()
_NONE.alive = False  # stands for entries that were not looked up yet

_Make = Callable[[Board, str, tuple[Any, ...]], Run]

MAX_NESTING = 190
"""How deeply the parentheses of generated code may nest; Python itself takes 200."""


def compile_script(script: Script, board: Board) -> Run:
    """A function that runs a script on a board and returns the value of its last statement, None for an empty one.

    Names are enums of the board first, then its keys. The function raises a ScriptError where the script cannot go on.

    Raises:
        ScriptError: The script nests too deeply.
    """
    return _compiled(script, board, False)


def compile_condition(script: Script, board: Board) -> Callable[[], bool]:
    """The same for a script whose value is true or false."""
    return _compiled(script, board, True)


def _compiled(script: Script, board: Board, condition: bool) -> Run:
    enums = frozenset(i for i, s in enumerate(script.slots) if s in board.enums) if board.enums else frozenset[int]()
    if script.form is not None:
        make = _maker(script.form, enums, condition)
    else:
        make = _made(script.statements, enums, condition)
    if make is None:
        hint = "Use several statements."
        raise ScriptError(script.text, 0, Fault(f"the script '{short(script.text)}' nests too deeply.", hint=hint))
    return make(board, script.text, script.slots)


@functools.lru_cache(maxsize=1024)
def _maker(form: Form, enums: frozenset[int], condition: bool) -> _Make | None:
    return _made(form.statements, enums, condition)


def _made(statements: tuple[Expression, ...], enums: frozenset[int], condition: bool) -> _Make | None:
    """The function that makes a script's function; None if its code nests too deeply for Python."""
    text = _source(statements, Slots(statements, enums), condition)
    if _nesting(text) > MAX_NESTING:
        return None
    space: dict[str, Any] = dict(_SPACE)
    exec(text, space)
    make: _Make = space["make"]
    return make


def _nesting(text: str) -> int:
    deepest = depth = 0
    for character in text:
        depth += (character in "([") - (character in ")]")
        deepest = max(deepest, depth)
    return deepest


def _source(statements: tuple[Expression, ...], slots: Slots, condition: bool) -> str:
    *others, last = statements or (None,)
    body = [line for statement in others for line in write_statement(statement, slots, "")]
    if last is None:
        body = ["return truth(None)" if condition else "return None"]
    else:
        body += write_statement(last, slots, "truth" if condition else "value")
    names = [f"s{i}" for i in range(slots.count)]
    lines = ["def make(board, text, slots):", *(f" s{i} = slots[{i}]" for i in range(slots.count))]
    lines += [f" f{i} = " + (f"float(board.enums[s{i}])" if i in slots.enums else f"real(s{i})") for i in slots.floats]
    lines += [f" entries = [NONE] * {slots.count}"]
    constants = ["board", "text", "entries", *names, *(f"f{i}" for i in slots.floats)]
    lines += [f" def run({', '.join(f'{name}={name}' for name in constants)}):"]  # faster, and smaller, than a closure
    lines += ["  try:", *(f"   {line}" for line in body)]
    lines += ["  except (Refused, OverflowError) as error:", "   raise stopped(text, error) from None", " return run"]
    return "\n".join(lines)


def _stopped(text: str, error: Exception) -> ScriptError:
    what = error if isinstance(error, Refused) else "a number is too large"
    return ScriptError(text, 0, Fault(f"the script '{short(text)}' cannot go on: {what}."))


_SPACE = {
    "E": EPSILON,
    "BITS": BITS,
    "NONE": _NONE,
    "Refused": Refused,
    "assign": assign,
    "assigned": assigned,
    "chosen": chosen,
    "compared": compared,
    "existing": existing,
    "folded": folded,
    "known": known,
    "negated": negated,
    "quotient": quotient,
    "real": real,
    "stopped": _stopped,
    "truth": truth,
}
"""The names that generated code uses."""
