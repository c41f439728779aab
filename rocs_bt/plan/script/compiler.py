"""From a parsed script to a function over one board."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from ...errors import Fault
from ..board import Board, Entry, from_string
from .arithmetic import BINARY, COMPARE, NUMBERS, Refused, comparable, divided, negated, number_of, shown, truth
from .error import ScriptError, short
from .fast import fast_condition
from .syntax import Assignment, Binary, Comparison, Conditional, Expression, Literal, Name, Script, Unary

Evaluate = Callable[[], Any]


def compile_script(script: Script, board: Board) -> Evaluate:
    """A function that runs a script on a board and gives its last statement's value back, None for an empty one.

    Names are enums of the board first, then its keys. The function raises a ScriptError where the script cannot go on.
    """
    compiler = _Compiler(script.text, board)
    steps = tuple(compiler.build(statement) for statement in script.statements)
    if len(steps) == 1:
        return steps[0]

    def run() -> Any:
        value = None
        for step in steps:
            value = step()
        return value

    return run


def compile_condition(script: Script, board: Board) -> Callable[[], bool]:
    """The same for a script whose value is a truth."""
    run = compile_script(script, board)

    def holds() -> bool:
        value = run()
        if value.__class__ is float:
            return bool(value)
        try:
            return truth(value)
        except Refused as refused:
            raise ScriptError(script.text, 0, _fault(script.text, str(refused))) from None

    return fast_condition(script, board, holds)


def _fault(text: str, what: str) -> Fault:
    return Fault(f"the script '{short(text)}' cannot go on: {what}.")


class _Compiler:
    def __init__(self, text: str, board: Board) -> None:
        self._text = text
        self._board = board

    def build(self, expression: Expression) -> Evaluate:
        match expression:
            case Literal():
                return partial(_same, expression.value)
            case Name():
                return self._name(expression)
            case Unary():
                return self._unary(expression)
            case Binary():
                return self._binary(expression)
            case Comparison():
                return self._comparison(expression)
            case Conditional():
                return self._conditional(expression)
            case Assignment():
                return self._assignment(expression)

    def _wrong(self, what: object, at: int) -> ScriptError:
        return ScriptError(self._text, at, _fault(self._text, str(what)))

    def _name(self, expression: Name) -> Evaluate:
        name, board = expression.name, self._board
        if name in board.enums:
            return partial(_same, float(board.enums[name]))
        entry: Entry | None = None

        def read() -> Any:
            nonlocal entry
            if entry is None or not entry.alive:
                entry = board.entry(name)
            if entry is None or entry.value is None:
                raise self._wrong(f"the board has no value at '{name}'", expression.at)
            return entry.value

        return read

    def _unary(self, expression: Unary) -> Evaluate:
        operand, operator = self.build(expression.operand), expression.operator

        def negate() -> float:
            try:
                return negated(operator, operand())
            except Refused as refused:
                raise self._wrong(refused, expression.at) from None

        return negate

    def _binary(self, expression: Binary) -> Evaluate:
        left, right = self.build(expression.left), self.build(expression.right)
        combine = BINARY[expression.operator]

        def combined() -> Any:
            a, b = left(), right()
            try:
                return combine(a, b)
            except Refused as refused:
                raise self._wrong(refused, expression.at) from None

        return combined

    def _comparison(self, expression: Comparison) -> Evaluate:
        tests = [COMPARE[operator] for operator in expression.operators]
        operands = [self.build(operand) for operand in expression.operands]
        enums, first, others = self._board.enums, operands[0], tuple(zip(tests, operands[1:], strict=True))

        def compare() -> float:
            left = first()
            for test, operand in others:
                right = operand()
                # Two doubles are by far the most common, and need no look at what they are.
                if left.__class__ is float and right.__class__ is float:
                    holds = test(left, right)
                else:
                    try:
                        holds = test(*comparable(left, right, enums))
                    except Refused as refused:
                        raise self._wrong(refused, expression.at) from None
                if not holds:
                    return 0.0
                left = right
            return 1.0

        return compare

    def _conditional(self, expression: Conditional) -> Evaluate:
        condition, then = self.build(expression.condition), self.build(expression.then)
        otherwise = self.build(expression.otherwise)

        def choose() -> Any:
            value = condition()
            if value.__class__ is not str and value.__class__ not in NUMBERS:
                raise self._wrong(f"{shown(value)} is neither true nor false", expression.at)
            return then() if value else otherwise()

        return choose

    def _assignment(self, expression: Assignment) -> Evaluate:
        board, name, at = self._board, expression.target.name, expression.at
        operator, value_of = expression.operator, self.build(expression.value)

        def assign() -> Any:
            entry = board.entry(name)
            if entry is None:
                if operator != ":=":
                    raise self._wrong(f"there is no '{name}' yet; ':=' makes it", at)
                entry = board.declare(name)
            value = value_of()
            try:
                entry.store(_assigned(board, name, entry, operator, value))
            except Refused as refused:
                raise self._wrong(f"'{name}' cannot become {shown(value)}: {refused}", at) from None
            return entry.value

        return assign


def _same(value: Any) -> Any:
    return value


def _assigned(board: Board, name: str, entry: Entry, operator: str, value: Any) -> Any:
    if operator not in (":=", "="):
        value = _combined(entry.value, operator, value)
    elif entry.value is None:
        return value if entry.kind is None else board.fitted(name, entry.kind, value)
    elif value.__class__ is str and entry.value.__class__ is not str:
        if entry.kind is not None:
            return from_string(value, entry.kind, board.enums)
        if entry.value.__class__ in NUMBERS:
            return number_of(value, board.enums)
        raise Refused("it holds no text")
    return _kept(entry.value, value)


def _combined(old: Any, operator: str, value: Any) -> Any:
    if old is None:
        raise Refused("it has no value yet")
    if value.__class__ in NUMBERS:
        if old.__class__ not in NUMBERS:
            raise Refused("it holds no number")
        a, b = float(old), float(value)
        return divided(a, b) if operator == "/=" else BINARY[operator[0]](a, b)
    if operator == "+=" and value.__class__ is str:
        return _text(old) + value
    raise Refused(f"'{operator}' is not for this value")


def _text(value: Any) -> str:
    if value.__class__ not in (str, *NUMBERS):
        raise Refused("it holds no text")
    return str(BINARY[".."](value, ""))


def _kept(old: Any, value: Any) -> Any:
    """A new value in the representation of the old one, as `Any::copyInto` keeps it."""
    kind, given = old.__class__, value.__class__
    if kind is given:
        return value
    if kind in NUMBERS and given in NUMBERS:
        if kind is float:
            return float(value)
        if given is float and not value.is_integer():
            raise Refused(f"it holds a whole number, and {value} is none")
        if abs(value) >= 2.0**63:
            raise Refused(f"it holds a whole number of 64 bits, and {value} has more")
        return int(value)
    raise Refused(f"it holds a value of type {kind.__name__}")
