"""Table of operators: those of the language, and the instructions of programs.

A row has the types of an operator, its text for the manual, its meaning for the prover (`z3`, `valid`), and the
instruction that computes it: `numpy` here, and the row of the same name in `kernel/operators.h`, which has the same
order. A new function is a row here and one there. `program` defines what each instruction computes; all NaN rules are
in these functions.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.geometry import wrap_angle
from . import argument_kinds as kinds
from . import symbolic, temporal
from .node import PLAIN, TRUTH, Kind, Node

Numbers = NDArray[np.float64]


class Form(Enum):
    """How an instruction computes; the value is the name of the macro in `kernel/operators.h`."""

    EACH = "EACH"  # one value of each operand, arrays of one shape, to one value
    GROUP = "GROUP"  # n values, shape (instructions, n, rows), to one, shape (instructions, rows)
    CELLS = "CELLS"  # temporal, with a fixed number of cells
    RING = "RING"  # temporal, with a ring buffer
    NONE = ""  # no instruction of its own: `lower` writes it with others


@dataclass(frozen=True)
class Operator:
    """Row of the table.

    Attributes:
        name: Name in the language, or of the instruction.
        form: Form of the instruction.
        operands: Number of operands of the instruction.
        numpy: Implementation of the instruction.
        usage: Call of a function of the language; empty for other operators.
        doc: Result of the function.
        kind: Function that returns the kind of the result for the arguments without the window; raises Misuse.
        window: Whether the last argument of the function is the length of a time window.
        cells: Number of cells of a CELLS instruction.
        z3: Meaning for the prover, a function of a `symbolic.Question` and of the operands; None if unknown.
        valid: Valid operands with which the result is certainly valid: `all`, or the `finite` ones; exceptions are in
            `reactive.analysis.validity`.
    """

    name: str
    form: Form
    operands: int = 1
    numpy: Callable[..., Any] | None = None
    usage: str = ""
    doc: str = ""
    kind: Callable[[Sequence[Node]], Kind] = kinds.one_unit
    window: bool = False
    cells: int = 0
    z3: Callable[..., Any] | None = None
    valid: str = ""


def _scalar(function: Callable[..., float]) -> Callable[..., Numbers]:
    """Instruction from a function of Python's numbers: numpy's own differs from the C library in the last digit."""

    def each(*arrays: Numbers) -> Numbers:
        values = map(function, *(array.ravel().tolist() for array in arrays))
        return np.array([*values], float).reshape(arrays[0].shape)

    return each


def _hypot(a: float, b: float) -> float:
    """Hypotenuse as the C library computes it; `math.hypot` differs in the last digit."""
    if math.isnan(a) or math.isnan(b):
        return math.nan
    try:
        return abs(complex(a, b))
    except OverflowError:
        return math.inf


def _where_valid(value: Any, *operands: Numbers) -> Numbers:
    valid = operands[0] == operands[0]
    for other in operands[1:]:
        valid &= other == other
    return np.where(valid, value, np.nan)


def _clip(a: Numbers, low: Numbers, high: Numbers) -> Numbers:
    raised = np.where(low > a, low, a)
    return _where_valid(np.where(high < raised, high, raised), a, low, high)


def _and(a: Numbers, b: Numbers) -> Numbers:
    return np.where((a == 0.0) | (b == 0.0), 0.0, a * b)


def _or(a: Numbers, b: Numbers) -> Numbers:
    return np.where((a == 1.0) | (b == 1.0), 1.0, a + b)


def _worst(a: Numbers, b: Numbers) -> Numbers:
    less = np.where((a != a) | (b < a), b, a)
    return np.where(((a == a) & (b == b)) | (less < 0.0), less, np.nan)


def _best(a: Numbers, b: Numbers) -> Numbers:
    return -_worst(-a, -b)


def _fold(fold: Callable[[Numbers, Numbers], Numbers]) -> Callable[[Numbers], Numbers]:
    """Reduction of a group from the first to the last value; numpy's own sums are pairwise."""
    return lambda group: functools.reduce(fold, group.swapaxes(0, 1))


def _min(group: Numbers) -> Numbers:
    found: Numbers = group.min(axis=1)
    if (found == 0.0).any():  # of zeros with two signs, the first
        found = np.take_along_axis(group, group.argmin(axis=1)[:, np.newaxis], 1)[:, 0]
    return found


def _max(group: Numbers) -> Numbers:
    return -_min(-group)


def _count(group: Numbers) -> Numbers:
    count: Numbers = group.sum(axis=1)  # truth values: 1, 0 or NaN, which stays
    return count


def _min_valid(group: Numbers, least: Numbers) -> Numbers:
    valid = group == group
    return np.where(valid.sum(axis=1) >= least[:, 0], _min(np.where(valid, group, np.inf)), np.nan)


_sum = _fold(np.add)

# The lambdas are instructions of one expression. Those of `z3` drop the question, which a negation does not need.
TABLE = (
    Operator("load", Form.EACH, 0),
    Operator("neg", Form.EACH, 1, np.negative, z3=lambda t, a: symbolic.negative(a), valid="all"),
    Operator("add", Form.EACH, 2, np.add, z3=symbolic.total, valid="finite"),
    Operator("sub", Form.EACH, 2, np.subtract, z3=symbolic.difference, valid="finite"),
    Operator("mul", Form.EACH, 2, np.multiply, z3=symbolic.product, valid="finite"),
    Operator("div", Form.EACH, 2, lambda a, b: np.where(b == 0.0, np.nan, a / b), z3=symbolic.quotient, valid="all"),
    Operator("min2", Form.EACH, 2, lambda a, b: _where_valid(np.where(b < a, b, a), a, b)),
    Operator("max2", Form.EACH, 2, lambda a, b: _where_valid(np.where(b > a, b, a), a, b)),
    Operator(
        "select", Form.EACH, 3, lambda a, b, c: _where_valid(np.where(c == 1.0, a, b), c), z3=symbolic.select,
        valid="all",
    ),
    Operator("lt", Form.EACH, 2, lambda a, b: _where_valid(a < b, a, b), z3=symbolic.less),
    Operator("le", Form.EACH, 2, lambda a, b: _where_valid(a <= b, a, b), z3=symbolic.less_or_equal),
    Operator("eq", Form.EACH, 2, lambda a, b: _where_valid(a == b, a, b), z3=symbolic.equal),
    Operator("ne", Form.EACH, 2, lambda a, b: _where_valid(a != b, a, b), z3=symbolic.different),
    Operator("not", Form.EACH, 1, lambda a: 1.0 - a, z3=lambda t, a: symbolic.negated(a), valid="all"),
    Operator("and", Form.EACH, 2, _and, z3=symbolic.conjunction, valid="all"),
    Operator("or", Form.EACH, 2, _or, z3=symbolic.disjunction, valid="all"),
    Operator("gap", Form.EACH, 3, lambda a, b, c: _where_valid(np.where(a == b, 0.0, (b - a) / c), a, b)),
    Operator("worst", Form.EACH, 2, _worst),
    Operator("best", Form.EACH, 2, _best),
    Operator("worst_of", Form.GROUP, 1, _fold(_worst)),
    Operator("best_of", Form.GROUP, 1, _fold(_best)),
    Operator("delay", Form.RING, 1, temporal.delay),
    Operator("lowest", Form.RING, 1, temporal.lowest),
    Operator("since_margin", Form.RING, 2, temporal.since_margin),
    Operator(
        "min", Form.GROUP, 1, _min,
        "min(group) or min(a, b, ...)", "the minimum", kinds.one_unit, z3=symbolic.least, valid="all",
    ),
    Operator(
        "max", Form.GROUP, 1, _max,
        "max(group) or max(a, b, ...)", "the maximum", kinds.one_unit, z3=symbolic.greatest, valid="all",
    ),
    Operator("sum", Form.GROUP, 1, _sum, "sum(group)", "the sum", kinds.one_group, z3=symbolic.total, valid="finite"),
    Operator("mean", Form.NONE, 1, None, "mean(group)", "the mean", kinds.one_group, z3=symbolic.mean, valid="finite"),
    Operator(
        "any", Form.GROUP, 1, _fold(_or),
        "any(group < a)", "whether at least one comparison is true", kinds.truths(TRUTH), z3=symbolic.disjunction,
        valid="all",
    ),
    Operator(
        "all", Form.GROUP, 1, _fold(_and), "all(group < a)", "whether all comparisons are true", kinds.truths(TRUTH),
        z3=symbolic.conjunction, valid="all",
    ),
    Operator(
        "count", Form.GROUP, 1, _count, "count(group < a)", "the number of true comparisons", kinds.truths(PLAIN),
        z3=symbolic.count, valid="all",
    ),
    Operator(
        "abs", Form.EACH, 1, np.abs,
        "abs(a)", "the absolute value, value by value", kinds.each_value, z3=symbolic.absolute, valid="all",
    ),
    Operator(
        "clip", Form.EACH, 3, _clip,
        "clip(a, low, high)", "a limited to low and high, value by value; high has precedence", kinds.limited,
        z3=symbolic.clip, valid="all",
    ),
    Operator(
        "hypot", Form.EACH, 2, _scalar(_hypot),
        "hypot(a, b)", "the length of the vector (a, b)", kinds.length, z3=symbolic.hypot,
    ),
    Operator("sign", Form.EACH, 1, np.sign, "sign(a)", "-1, 0 or 1", kinds.direction, z3=symbolic.sign, valid="all"),
    Operator(
        "side", Form.EACH, 1, lambda a: _where_valid(np.where(a >= 0.0, 1.0, -1.0), a),
        "side(a)", "-1 or 1; side(0) is 1, so that a turn is never zero", kinds.direction, z3=symbolic.side,
        valid="all",
    ),
    Operator(
        "sqrt", Form.EACH, 1, np.sqrt,
        "sqrt(a)", "the square root; invalid for a negative number", kinds.root, z3=symbolic.sqrt,
    ),
    Operator(
        "wrap_angle", Form.EACH, 1, _scalar(lambda a: math.nan if math.isinf(a) else wrap_angle(a)),
        "wrap_angle(a)", "the same angle in (-180, 180] deg; invalid if infinite", kinds.angle, z3=symbolic.wrap_angle,
    ),
    Operator(
        "min_valid", Form.GROUP, 2, _min_valid,
        "min_valid(group, k)", "the minimum of the valid values; invalid only if fewer than k are valid",
        kinds.valid_values, z3=symbolic.min_valid,
    ),
    Operator(
        "argmin", Form.GROUP, 1, lambda group: _where_valid(group.argmin(axis=1), group.min(axis=1)),
        "argmin(group)", "the index of the minimum, from 0; the first of equal values", kinds.index, z3=symbolic.argmin,
    ),
    Operator(
        "dot", Form.GROUP, 2, lambda group, vector: _sum(group * vector),
        "dot(group, [a, b, ...])", "the dot product with constants", kinds.product, z3=symbolic.dot, valid="finite",
    ),
    Operator(
        "atan2", Form.EACH, 2, _scalar(math.atan2),
        "atan2(y, x)", "the angle of the point (x, y)", kinds.arc, z3=symbolic.atan2,
    ),
    Operator(
        "held", Form.CELLS, 1, temporal.held,
        "held(test, 0.2 s)", "whether the test has been true for this time", kinds.past(1, TRUTH), window=True, cells=2,
        z3=symbolic.held,
    ),
    Operator(
        "once", Form.NONE, 1, None,
        "once(test, 2 s)", "whether the test was true at any time in the last 2 s", kinds.past(1, TRUTH), window=True,
        z3=symbolic.once,
    ),
    Operator(
        "since", Form.CELLS, 2, temporal.since,
        "since(a, b, 2 s)", "whether b was true in the last 2 s, and a has been true since then", kinds.past(2, TRUTH),
        window=True, cells=2, z3=symbolic.since,
    ),
    Operator(
        "time_since", Form.CELLS, 1, temporal.time_since,
        "time_since(test)", "the time since the test last held; inf: never", kinds.past(1, kinds.DURATION), cells=1,
        z3=symbolic.time_since,
    ),
    Operator(
        "rate", Form.RING, 1, temporal.rate,
        "rate(a, 0.5 s)", "the mean rate of change of a over the last 0.5 s", kinds.change, window=True,
        z3=symbolic.rate,
    ),
)  # fmt: skip  # a row has two or three lines, so that the whole table can be read at once

FUNCTIONS: Mapping[str, Operator] = {row.name: row for row in TABLE if row.usage}
INSTRUCTIONS = tuple(row for row in TABLE if row.form is not Form.NONE)
CODES: Mapping[str, int] = {row.name: code for code, row in enumerate(INSTRUCTIONS)}
ROWS: Mapping[str, Operator] = {row.name: row for row in TABLE}
SIGNS: Mapping[str, str] = {"+": "add", "-": "sub", "*": "mul", "/": "div", "if": "select"}
"""Names of instructions for operators of expressions with other names."""
COMPARISONS: Mapping[str, str] = {"<": "lt", "<=": "le", ">": "lt", ">=": "le", "==": "eq", "!=": "ne"}
"""Names of instructions for signs of comparisons; the operands of > and >= are exchanged."""
