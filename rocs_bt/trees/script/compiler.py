"""Compiler from a parsed script to a function that works on one blackboard.

Each operator becomes a closure that calls the closures of its operands. Common operators (comparisons, sums, products)
have a fast path for floats and ints. All other cases use the functions of `arithmetic`, which accept any value and
raise Refused with the reason if they cannot compute a result.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from ...base.errors import Fault
from ..board import Board, BoardEntry
from .arithmetic import (
    BINARY,
    EPSILON,
    Refused,
    as_double,
    assigned,
    choice_truth,
    compared,
    existing_entry,
    negated,
    required_value,
    truth,
)
from .form import Script
from .parser import (
    Assignment,
    Binary,
    Comparison,
    Conditional,
    Expression,
    Literal,
    Name,
    ScriptError,
    Unary,
    short,
)

Run = Callable[[], Any]
_Pair = Callable[[Any, Any], Any]

_UNRESOLVED = BoardEntry()
_UNRESOLVED.alive = False  # placeholder for entries that are not resolved yet


def _apart(left: float, right: float) -> bool:
    return not abs(left - right) <= EPSILON


def _close(left: float, right: float) -> bool:
    return abs(left - right) <= EPSILON


_UNLESS: Mapping[str, _Pair] = {
    "==": _apart,
    "!=": _close,
    "<": operator.ge,
    ">": operator.le,
    "<=": operator.gt,
    ">=": operator.lt,
}
"""Negated comparisons of numbers, as in the C++ source; the negation matters for NaN."""

_TEXT_UNLESS: Mapping[str, _Pair] = {**_UNLESS, "==": operator.ne, "!=": operator.eq}

_LOGIC = ("&&", "||")
_FLOATS: Mapping[str, _Pair] = {"+": operator.add, "-": operator.sub, "*": operator.mul}


def compile_script(script: Script, board: Board) -> Run:
    """Compile a script to a function that returns the value of its last statement, None for an empty script.

    A name is an enum value of the blackboard, or else a key. The function raises a ScriptError if the script cannot
    continue. Nodes compile their scripts when their tree is bound, so that the first tick takes no longer than others.
    """
    return _with_script_errors(script, board, condition=False)


def compile_condition(script: Script, board: Board) -> Callable[[], bool]:
    """Compile a script to a function that returns true or false."""
    return _with_script_errors(script, board, condition=True)


def _with_script_errors(script: Script, board: Board, condition: bool) -> Run:
    """Compile a script to a function that raises Refused and overflow as ScriptError."""
    run = _Compiler(script, board).run(condition)

    def runs() -> Any:
        try:
            return run()
        except (Refused, OverflowError) as error:
            what = error if isinstance(error, Refused) else "number too large"
            message = f"the script '{short(script.text)}' fails: {what}."
            raise ScriptError(script.text, 0, Fault(message)) from None

    return runs


class _Compiler:
    """Compiler of one script.

    The syntax tree may be shared with other scripts (see `Form`). The names and literals of this script are in its
    slots, in the order of the text. Expressions must therefore be compiled from left to right.
    """

    def __init__(self, script: Script, board: Board) -> None:
        self._statements = script.statements if script.form is None else script.form.statements
        self._slots: Iterator[Any] = iter(script.slots)
        self._board = board

    def run(self, condition: bool) -> Run:
        """Function of all statements; it returns true or false if the script is a condition."""
        if not self._statements:
            return lambda: truth(None) if condition else None
        *others, end = self._statements
        first = [self._value(statement) for statement in others]
        last = self._truth(end) if condition else self._value(end)
        if not first:
            return last

        def run() -> Any:
            for statement in first:
                statement()
            return last()

        return run

    def _value(self, expression: Expression) -> Run:
        return _BY_CLASS[expression.__class__](self, expression)

    def _literal(self, expression: Literal) -> Run:
        value = next(self._slots)
        return lambda: value

    def _unary(self, expression: Unary) -> Run:
        inner, sign = self._value(expression.operand), expression.operator
        return lambda: negated(sign, inner())

    def _as_number(self, expression: Expression) -> Run:
        """Function of a comparison or of `&&` and `||`."""
        holds = self._truth(expression)
        return lambda: 1.0 if holds() else 0.0

    def _binary(self, expression: Binary) -> Run:
        return self._as_number(expression) if expression.operator in _LOGIC else self._chain(expression)

    def _conditional(self, expression: Conditional) -> Run:
        condition = self._choice(expression.condition)
        then, other = self._value(expression.then), self._value(expression.otherwise)
        return lambda: then() if condition() else other()

    def _truth(self, expression: Expression) -> Run:
        """Function of an expression used as a condition."""
        if isinstance(expression, Comparison):
            return self._comparison(expression)
        if isinstance(expression, Binary) and expression.operator in _LOGIC:
            return self._logic(expression)
        value = self._value(expression)
        return lambda: truth(value())

    def _choice(self, condition: Expression) -> Run:
        """Function of the condition of `?`, which accepts more values than other conditions."""
        if isinstance(condition, Comparison):
            return self._comparison(condition)
        value = self._value(condition)
        return lambda: choice_truth(value())

    def _logic(self, expression: Binary) -> Run:
        """Function of `a && b && c` or `a || b || c`; all operands are evaluated, as in BehaviorTree.CPP."""
        parts, left = list[Expression](), expression.left
        parts.append(expression.right)
        while isinstance(left, Binary) and left.operator == expression.operator:
            parts.append(left.right)
            left = left.left
        truths = [self._truth(part) for part in (left, *reversed(parts))]
        if len(truths) > 2:
            combine = all if expression.operator == "&&" else any
            return lambda: combine([holds() for holds in truths])
        first, second = truths

        def both() -> Any:
            a, b = first(), second()
            return a and b

        def either() -> Any:
            a, b = first(), second()
            return a or b

        return both if expression.operator == "&&" else either

    def _name(self, expression: Name) -> Run:
        name, board = next(self._slots), self._board
        if name in board.enums:
            number = float(board.enums[name])
            return lambda: number
        entry = _UNRESOLVED

        def get() -> Any:
            nonlocal entry
            if not entry.alive:
                entry = board.entry(name) or _UNRESOLVED
            value = entry.value
            return required_value(value, name) if value is None else value

        return get

    def _chain(self, expression: Binary) -> Run:
        """Function of a chain such as `a + b - c`, which may be longer than Python's recursion limit."""
        links, left = list[Binary](), expression
        while True:
            links.append(left)
            if not isinstance(left.left, Binary) or left.left.operator in _LOGIC:
                break
            left = left.left
        first = self._value(left.left)
        pairs = [(link.operator, link.right, self._value(link.right)) for link in reversed(links)]
        if len(pairs) == 1:
            ((sign, operand, right),) = pairs
            return _sum(sign, first, right, _number(operand, right))
        steps = [(BINARY[sign], right) for sign, _, right in pairs]

        def chained() -> Any:
            value = first()
            for combine, right in steps:
                value = combine(value, right())
            return value

        return chained

    def _comparison(self, expression: Comparison) -> Run:
        enums, (sign, *signs) = self._board.enums, expression.operators
        first, (operand, *operands) = self._value(expression.operands[0]), expression.operands[1:]
        if isinstance(operand, Literal) and not operands:
            return _compared_with_literal(first, sign, next(self._slots), enums)
        right, unless = self._value(operand), _UNLESS[sign]
        rest = [(sign, self._value(operand)) for sign, operand in zip(signs, operands, strict=True)]

        def holds() -> bool:
            a, b = first(), right()
            if a.__class__ is float and b.__class__ is float:
                if unless(a, b):
                    return False
            elif not compared(sign, a, b, enums):
                return False
            for link, operand in rest:
                a, b = b, operand()
                if not compared(link, a, b, enums):
                    return False
            return True

        return holds

    def _assignment(self, expression: Assignment) -> Run:
        name, board, sign = next(self._slots), self._board, expression.operator
        value = self._value(expression.value)
        sets, combine = sign in (":=", "="), _FLOATS.get(sign[0])
        entry = _UNRESOLVED

        def assign() -> Any:
            nonlocal entry
            if not entry.alive:
                entry = (board.entry(name) or board.declare(name)) if sign == ":=" else existing_entry(board, name)
            given = value()
            old = entry.value
            if sets and old.__class__ is given.__class__ and old is not None:
                new = given
            elif combine is not None and old.__class__ is float and given.__class__ in (float, int):
                new = combine(old, float(given))
            else:
                new = assigned(board, name, entry, sign, given)
            entry.value = new
            entry.sequence += 1
            return new

        return assign


_BY_CLASS: Mapping[type[Any], Callable[[_Compiler, Any], Run]] = {
    Literal: _Compiler._literal,
    Name: _Compiler._name,
    Unary: _Compiler._unary,
    Binary: _Compiler._binary,
    Comparison: _Compiler._as_number,
    Conditional: _Compiler._conditional,
    Assignment: _Compiler._assignment,
}
"""Compiling methods; a table, because a chain of tests of the class takes a third of the time of a large document."""


def _number(expression: Expression, value: Run) -> float | None:
    """Value of a number literal as a float; None for any other expression."""
    if isinstance(expression, Literal) and not isinstance(expression.value, str):
        return as_double(value())
    return None


def _sum(sign: str, left: Run, right: Run, number: float | None) -> Run:
    """Function of one binary operator.

    Args:
        sign: Operator.
        left: Compiled left operand.
        right: Compiled right operand.
        number: Value of the right operand if it is a number literal, for a faster function; else None.
    """
    combine, quick = BINARY[sign], _FLOATS.get(sign)
    if quick is None:
        return lambda: combine(left(), right())
    if number is None:

        def of_two() -> Any:
            a, b = left(), right()
            return quick(a, b) if a.__class__ is float and b.__class__ is float else combine(a, b)

        return of_two

    def of_one() -> Any:
        value = left()
        return quick(value, number) if value.__class__ is float else combine(value, number)

    return of_one


def _compared_with_literal(left: Run, sign: str, limit: float | str, enums: Mapping[str, int]) -> Run:
    """Function of a comparison with a literal."""
    text = isinstance(limit, str)
    one, other = (str, str) if text else (float, int)
    unless = _TEXT_UNLESS[sign] if text else _UNLESS[sign]
    if not isinstance(limit, str):
        limit = as_double(limit)

    def holds() -> bool:
        value = left()
        if value.__class__ is one or value.__class__ is other:
            return not unless(value, limit)
        return compared(sign, value, limit, enums)

    return holds
