"""Conditions over numbers as Python functions of their own; all others are left to the compiler.

Most conditions compare keys that hold numbers. Of those a Python expression is written and compiled once. It looks
whether every key it asks holds a number indeed, and gives the question to the compiler's function where one does not,
which also tells what is wrong. A condition has no side effects before an assignment, so asking twice does no harm.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from ..board import Board
from .arithmetic import EPSILON
from .syntax import Binary, Comparison, Expression, Literal, Name, Script, Unary

_COMPARE = {
    "==": "-E <= {0} - {1} <= E",
    "!=": "not -E <= {0} - {1} <= E",
    "<": "not {0} >= {1}",
    ">": "not {0} <= {1}",
    "<=": "not {0} > {1}",
    ">=": "not {0} < {1}",
}


class _Unfit(Exception):
    """There is something in the condition that is not written as Python."""


def fast_condition(script: Script, board: Board, slowly: Callable[[], bool]) -> Callable[[], bool]:
    """A condition as one Python function, or as it was.

    Args:
        script: The condition.
        board: Its board.
        slowly: The compiler's function for it.
    """
    writer = _Writer(board)
    try:
        (statement,) = script.statements
        text = writer.truth(statement)
    except (_Unfit, ValueError):
        return slowly
    found: Callable[[], bool] = _made(text, len(writer.names), len(writer.numbers))(
        board, slowly, EPSILON, writer.names, writer.numbers
    )
    return found


@functools.lru_cache(maxsize=1024)
def _made(text: str, names: int, numbers: int) -> Callable[..., Callable[[], bool]]:
    """The maker of a condition's function. Conditions of one form, whatever their keys and numbers, have one maker."""
    lines = ["def make(board, slowly, E, names, numbers):"]
    lines += [f"    n{i}, e{i} = names[{i}], None" for i in range(names)]
    lines += [f"    k{i} = numbers[{i}]" for i in range(numbers)]
    lines += ["    def holds():"]
    lines += [f"        nonlocal e{i}" for i in range(names)]
    for i in range(names):
        lines += [
            f"        if e{i} is None or not e{i}.alive:",
            f"            e{i} = board.entry(n{i})",
            f"            if e{i} is None:",
            "                return slowly()",
            f"        v{i} = e{i}.value",
            f"        if v{i}.__class__ is not float and v{i}.__class__ is not int:",
            "            return slowly()",
        ]
    lines += ["        try:", f"            return {text}", "        except (ZeroDivisionError, OverflowError):"]
    lines += ["            return slowly()", "    return holds"]
    space: dict[str, Any] = {}
    exec("\n".join(lines), space)
    made: Callable[..., Callable[[], bool]] = space["make"]
    return made


class _Writer:
    def __init__(self, board: Board) -> None:
        self._enums = board.enums
        self.names: list[str] = []
        self.numbers: list[float] = []

    def truth(self, expression: Expression) -> str:
        """An expression that is true or false."""
        if isinstance(expression, Comparison):
            operands = [self.number(e) for e in expression.operands]
            if len(operands) > 2 and not all(isinstance(e, Name | Literal) for e in expression.operands):
                raise _Unfit
            pairs = zip(expression.operators, operands, operands[1:], strict=False)
            return "(" + " and ".join(f"({_COMPARE[o].format(a, b)})" for o, a, b in pairs) + ")"
        if isinstance(expression, Binary) and expression.operator in ("&&", "||"):
            left, right = self.truth(expression.left), self.truth(expression.right)
            return f"({left} {'and' if expression.operator == '&&' else 'or'} {right})"
        if isinstance(expression, Unary) and expression.operator == "!":
            return f"(not {self.truth(expression.operand)})"
        raise _Unfit

    def number(self, expression: Expression) -> str:
        """An expression that is a number."""
        if isinstance(expression, Literal) and not isinstance(expression.value, str):
            return self._literal(expression.value)
        if isinstance(expression, Name):
            if expression.name in self._enums:
                return self._literal(self._enums[expression.name])
            if expression.name not in self.names:
                self.names.append(expression.name)
            return f"v{self.names.index(expression.name)}"
        if isinstance(expression, Unary) and expression.operator == "-":
            return f"(-{self.number(expression.operand)})"
        if isinstance(expression, Binary) and expression.operator in "+-*/":
            return f"({self.number(expression.left)} {expression.operator} {self.number(expression.right)})"
        raise _Unfit

    def _literal(self, value: float) -> str:
        self.numbers.append(float(value))
        return f"k{len(self.numbers) - 1}"
