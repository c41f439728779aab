"""Translator from expressions to questions for z3. Only the first proof imports this module, because z3 takes 40 ms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import z3

from ...expression import Kind, Node, evaluate
from ...expression.operators import COMPARISONS, ROWS, SIGNS
from ...expression.symbolic import (
    Clip,
    Condition,
    Number,
    Term,
    Truth,
    all_of,
    any_of,
    bad_of,
    conjunction,
    disjunction,
    exact,
    no,
    to_float,
)
from .sample import Array


@dataclass(frozen=True)
class Solution:
    """Result of a search for values.

    Attributes:
        x: Snapshot that satisfies all that is known of the expression; None if none was found.
        never: Whether it is proved that there is none.
        steps: Steps of z3 that it took.
        unknown: Source texts of subexpressions of which only a part of the meaning is known.
        reason: z3's reason if it found neither a snapshot nor a proof; else empty.
    """

    x: Array | None
    never: bool
    steps: int
    unknown: tuple[str, ...]
    reason: str


class Translator:
    """Translator of expressions over the same signals to terms of z3.

    Args:
        bounds: Bounds of each value of the snapshot.
    """

    def __init__(self, bounds: Sequence[tuple[float, float]]) -> None:
        self.context = z3.Context()  # its own, because agents check rules in their threads
        self._solver = z3.SimpleSolver(ctx=self.context)
        self._bounds = bounds
        self._known: dict[Node, tuple[Any, dict[Condition, None]]] = {}
        self._conditions: dict[Condition, None] = {}  # of the value that is being translated, as keys
        self._signals: dict[int, Number] = {}
        self._ranges: dict[int, Condition] = {}
        self._constants: dict[float, Number] = {}
        self._text = ""  # of the operator that is being translated
        self._variables = self._steps = 0

    def solve(self, node: Node, free: Array, steps: int, steady: bool = False) -> Solution:
        """Find values of the signals for which a scalar boolean expression is true.

        Args:
            node: The expression.
            free: Values of the signals that the expression leaves free, shape (size,).
            steps: Maximum number of steps of z3, which do not depend on the computer.
            steady: Whether to assume that all signals have been constant for longer than all time windows.
        """
        self._conditions = {}
        true, marks = self.value(node).true, {n.value for n in node.walk() if n.op == "number"}
        conditions = [c for c in self._conditions if steady or not c.steady]
        unknown = tuple(dict.fromkeys(c.unknown for c in self._conditions if c.unknown))
        solver, before = self._solver, self._steps
        solver.push()
        solver.set("rlimit", steps)
        solver.add(true, *(c.term for c in conditions))
        solver.add(*(c.divided(mark) for c in conditions if isinstance(c, Clip) for mark in sorted(marks)))
        found = solver.check()
        self._steps = solver.statistics().get_key_value("rlimit count")
        x = self._snapshot(solver.model(), free) if found == z3.sat else None
        reason = solver.reason_unknown() if found == z3.unknown else ""
        solver.pop()
        return Solution(x, found == z3.unsat, self._steps - before, unknown, reason)

    def _snapshot(self, model: z3.ModelRef, free: Array) -> Array:
        x = free.copy()
        for index, signal in self._signals.items():
            over, under = (z3.is_expr(end) and z3.is_true(model[end]) for end in (signal.over, signal.under))
            found = model[signal.real]
            if over or under:
                x[index] = math.inf if over else -math.inf
            elif found is not None:
                x[index] = to_float(found.approx(20) if z3.is_algebraic_value(found) else found)
        return x

    def value(self, node: Node) -> Any:
        """Number or truth value of an expression, or a list of them; its conditions are added to the question's."""
        if node not in self._known:
            outer, self._conditions = self._conditions, {}
            self._known[node] = self._new(node), self._conditions
            self._conditions = outer
        value, conditions = self._known[node]
        self._conditions |= conditions
        return value

    def number(self, value: float) -> Number:
        if value not in self._constants:
            real = exact(value if math.isfinite(value) else 0.0, self.context)
            self._constants[value] = Number(real, value == math.inf, value == -math.inf, math.isnan(value))
        return self._constants[value]

    def real(self) -> Term:
        self._variables += 1
        return z3.Real(f"r{self._variables}", self.context)

    def flag(self) -> Term:
        self._variables += 1
        return z3.Bool(f"b{self._variables}", self.context)

    def require(self, condition: Condition | Term, steady: bool = False, partly: bool = False) -> None:
        if not isinstance(condition, Condition):
            condition = Condition(condition, steady, self._text if partly else "")
        self._conditions[condition] = None

    def _new(self, node: Node) -> Any:
        args = node.args
        if node.kind.size:
            return [self.value(_element(node, i)) for i in range(node.kind.size)]
        if node.op == "read":
            return self._signal(node.start)
        if node.op == "truth":
            return Truth(bool(node.value))
        if node.constant and not node.kind.boolean:
            value = evaluate(node, ())
            return self.number(math.nan if value is None else value)
        if node.op == "compare":
            return conjunction(self, *(self._compared(pair.signs[0], *pair.args) for pair in node.pairs))
        values = [self.value(arg) for arg in (args[1:] + args[:1] if node.op == "if" else args)]
        self._text = node.text
        row = ROWS[SIGNS.get(node.op, node.op)]
        return row.z3(self, *values) if row.z3 is not None else self._unknown(node.kind.boolean)

    def _unknown(self, boolean: bool) -> Number | Truth:
        """Any value, of an operator without a meaning in z3: it is never wrong, but a proof may need more."""
        if boolean:
            truth = Truth(self.flag(), self.flag())
            self.require(any_of(truth.valid, no(truth.true)), partly=True)
            return truth
        number = Number(self.real(), self.flag(), self.flag(), self.flag())
        self.require(no(all_of(number.over, number.under)), partly=True)
        return number

    def _signal(self, index: int) -> Number:
        if index not in self._signals:
            low, high = self._bounds[index]
            real = z3.Real(f"x{index}", self.context)
            over = z3.Bool(f"over{index}", self.context) if high == math.inf else False
            under = z3.Bool(f"under{index}", self.context) if low == -math.inf else False
            self._signals[index] = Number(real, over, under)
            least = math.isinf(low) or real >= self.number(low).real
            most = math.isinf(high) or real <= self.number(high).real
            self._ranges[index] = Condition(all_of(least, most, no(all_of(over, under))))
        self.require(self._ranges[index])
        return self._signals[index]

    def _compared(self, sign: str, a: Node, b: Node) -> Truth:
        """Comparison of two numbers. `min(a, b) < c` becomes `a < c or b < c`, which needs no variable."""
        if sign in (">", ">="):
            a, b = b, a
        row = ROWS[COMPARISONS[sign]]
        assert row.z3 is not None
        if row.name in ("lt", "le"):
            for extreme, lesser in ((a, True), (b, False)):
                parts = [self.value(part) for part in _parts(extreme)]
                if not parts or (extreme.op == "min_valid" and bad_of(*parts) is not False):
                    continue
                other = self.value(b if lesser else a)
                each = [row.z3(self, *((part, other) if lesser else (other, part))) for part in parts]
                any_is_enough = lesser is (extreme.op in ("min", "min_valid"))
                found = disjunction(self, *each) if any_is_enough else conjunction(self, *each)
                valid = all_of(*(t.valid for t in each))
                return Truth(all_of(valid, found.true), valid)
        truth: Truth = row.z3(self, self.value(a), self.value(b))
        return truth


def _element(node: Node, i: int) -> Node:
    """Expression of the i-th value of an expression with a group of values; a single value is returned unchanged."""
    if not node.kind.size:
        return node
    if node.op == "vector":
        return node.args[i]
    kind = Kind(node.kind.dimension, 0, node.kind.boolean)
    if node.op == "read":
        return replace(node, kind=kind, start=node.start + i, stop=node.start + i + 1, text=f"{node.text}[{i}]")
    return replace(node, kind=kind, args=tuple(_element(arg, i) for arg in node.args))


def _parts(node: Node) -> list[Node]:
    """Expressions of which a `min`, `max`, `min_valid` or `abs` is the minimum or maximum; none for other operators."""
    if node.op == "abs":
        (arg,) = node.args
        return [arg, Node("neg", arg.kind, (arg,), text=f"-({arg.text})")]
    if node.op not in ("min", "max", "min_valid") or node.constant:
        return []
    groups = node.args if node.op != "min_valid" else node.args[:1]
    return [_element(group, i) for group in groups for i in range(max(1, group.kind.size))]
