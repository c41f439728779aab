"""Compiler from expressions to Python functions, which give the interpreter's values 16 to 40 times faster."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .environment import Environment
from .lower import lower
from .node import Node
from .parser import parse
from .program import Program
from .python_code import PythonCode, define, sum_code

Snapshot = NDArray[np.float64] | Sequence[float]


class Expression:
    """Compiled expression with a single value, called with a snapshot of the signals.

    An expression with temporal operators keeps state between calls: each call is a sample. A call with an earlier time
    than the last one resets this state.

    Args:
        node: Typed tree of the expression.
        margins: Whether each call also computes the robustness margin, for an expression with a truth value.

    Attributes:
        node: Typed tree of the expression.
        margin: Robustness margin at the last call, positive if the expression was true; NaN if unknown or not
            requested.
    """

    def __init__(self, node: Node, margins: bool = False) -> None:
        self.node = node
        self.margin = math.nan
        self._margins = margins
        self._time = -math.inf

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expression) and self.node == other.node

    def __hash__(self) -> int:
        return hash(self.node)

    @property
    def text(self) -> str:
        """Text of the expression."""
        return self.node.text

    def __call__(self, x: Snapshot, t: float = 0.0) -> float | bool | None:
        """Value on a snapshot; None if invalid, because a required signal is NaN or the result is not a number.

        Args:
            x: Snapshot of all signals, SI units, shape (size,).
            t: Time of the snapshot [s].
        """
        if t < self._time:
            self.reset()
        self._time = t
        value: float | bool | None
        value, self.margin = self._function(x.tolist() if isinstance(x, np.ndarray) else x, t, self._cells)
        return value

    def prepare(self) -> None:
        """Compile the expression now; otherwise the first call compiles it, which takes about a millisecond."""
        _ = self._function

    def reset(self) -> None:
        """Discard the state of all earlier calls."""
        self._time = -math.inf
        self._cells[:] = self._program.cells.tolist()

    @cached_property
    def _program(self) -> Program:
        return lower([self.node], margins=int(self._margins))

    @cached_property
    def _cells(self) -> list[float]:
        cells: list[float] = self._program.cells.tolist()
        return cells

    @cached_property
    def _function(self) -> Callable[[Sequence[float], float, list[float]], tuple[Any, float]]:
        program = self._program
        lines = [f"def expression(x, t, cells):  # {' '.join(self.text.split())}"]
        if program.reads:
            lines += [f"    s = {sum_code(program)}", "    if s != s:", "        return careful(x, t, cells)"]
        lines += _body(program, fast=True)
        lines += ["def careful(x, t, cells):", *_body(program, fast=False)]
        return define("\n".join(lines), "expression")


class Values:
    """Compiled expressions that are evaluated together, also with several values; a call is a sample, as of Expression.

    Args:
        nodes: Typed trees of the expressions.
    """

    def __init__(self, nodes: Sequence[Node]) -> None:
        program = lower(nodes)
        sizes = [node.kind.size for node in nodes]
        lines = ["def values(x, t, cells):"]
        if program.reads:
            lines += [f"    s = {sum_code(program)}", "    if s != s:", "        return careful(x, t, cells)"]
        lines += _values_body(program, sizes, fast=True)
        lines += ["def careful(x, t, cells):", *_values_body(program, sizes, fast=False)]
        self._function = define("\n".join(lines), "values")
        self._cells: list[float] = program.cells.tolist()

    def __call__(self, x: Sequence[float], t: float) -> list[float | bool | None]:
        """Values of all expressions on a snapshot, one after the other; NaN or None for what is invalid.

        Args:
            x: Snapshot of all signals, SI units.
            t: Time of the snapshot, not before that of the last call [s].
        """
        found: list[float | bool | None] = self._function(x, t, self._cells)
        return found


def _values_body(program: Program, sizes: Sequence[int], fast: bool) -> list[str]:
    roots = program.roots.tolist()
    code = PythonCode(program, roots, fast)
    found = (f"*{code.value(r, n)}" if n else code.value(r) for r, n in zip(roots, sizes, strict=True))
    return [*(f"    {line}" for line in code.lines), f"    return [{', '.join(found)}]"]


def _body(program: Program, fast: bool) -> list[str]:
    root, margin = int(program.roots[0]), int(program.margins[0])
    code = PythonCode(program, [root] if margin < 0 else [root, margin], fast)
    lines = [f"    {line}" for line in code.lines]
    margin_code = "nan" if margin < 0 else code.value(margin)
    if program.truth[root] or code.sure(root):
        return [*lines, f"    return {code.value(root)}, {margin_code}"]
    return [*lines, f"    v = {code.value(root)}", f"    return (None if v != v else v), {margin_code}"]


def compile_plain(
    node: Node, argument: str = "x", head: Sequence[str] = (), names: Mapping[str, Any] | None = None
) -> Callable[[Any], Any]:
    """Compile an expression without temporal operators, with a single value, to a plain Python function.

    Args:
        node: Typed tree of the expression.
        argument: Name of the function's argument.
        head: Source lines that compute `x`, the values that the expression reads, from the argument; not needed if the
            argument is `x`.
        names: Objects that these source lines use, by name.

    Returns:
        Function from the argument to the value; the value is None if invalid.
    """
    program = lower([node])
    lines = [f"def plain({argument}):  # {' '.join(node.text.split())}", *(f"    {line}" for line in head)]
    if program.reads:
        lines += [f"    s = {sum_code(program)}", "    if s != s:", "        return careful(x)"]
    lines += _plain_body(program, fast=True)
    return define("\n".join([*lines, "def careful(x):", *_plain_body(program, fast=False)]), "plain", names)


def _plain_body(program: Program, fast: bool) -> list[str]:
    root = int(program.roots[0])
    code = PythonCode(program, [root], fast)
    lines = [f"    {line}" for line in code.lines]
    if program.truth[root] or code.sure(root):
        return [*lines, f"    return {code.value(root)}"]
    return [*lines, f"    v = {code.value(root)}", "    return None if v != v else v"]


def compile_expression(text: str, environment: Environment) -> Expression:
    """Parse and compile an expression with a single value.

    Raises:
        InputError: See `parse`.
    """
    return compile_node(parse(text, environment))


def compile_node(node: Node, margins: bool = False) -> Expression:
    """Compile a typed tree with a single value; arguments as in Expression."""
    return Expression(node, margins)
