"""Exact feasibility test for linear inequalities: the simplex method for bounded variables, with fractions.

Source: B. Dutertre, L. de Moura, "A fast linear-arithmetic solver for DPLL(T)" (CAV 2006). As there, a value is a pair
(a, b) that means a + b*epsilon with an infinitesimal epsilon, so that a strict bound `x < c` is `x <= c - epsilon`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from .formula import Effort, Row


@dataclass(frozen=True)
class Span:
    """Interval of a variable; an end is a float only if it is infinite."""

    low: Fraction | float = -math.inf
    high: Fraction | float = math.inf
    above: bool = False  # whether `low` itself is excluded
    under: bool = False  # whether `high` itself is excluded
    low_why: int = 0  # bit set of the search decisions from which `low` follows
    high_why: int = 0  # the same of `high`

    @property
    def empty(self) -> bool:
        """Whether the interval is empty."""
        return self.low > self.high or (self.low == self.high and (self.above or self.under))

    @staticmethod
    def of(low: float, high: float) -> Span:
        """Closed interval between two numbers."""
        return Span(low if math.isinf(low) else Fraction(low), high if math.isinf(high) else Fraction(high))

    def cut(self, value: Fraction | float, upper: bool, strict: bool, why: int = 0) -> Span:
        """Intersect the interval with a bound; returns `self` if the bound does not narrow it."""
        if upper and (value < self.high or (value == self.high and strict and not self.under)):
            return Span(self.low, value, self.above, strict, self.low_why, why)
        if not upper and (value > self.low or (value == self.low and strict and not self.above)):
            return Span(value, self.high, strict, self.under, why, self.high_why)
        return self

    def pick(self) -> Fraction | float:
        """Choose a value in the interval: with few digits, and away from the ends if the interval is wide enough."""
        if self.low == self.high:
            return self.low
        if isinstance(self.low, float):
            top = 1 if isinstance(self.high, float) else math.floor(self.high)
            return Fraction(min(top - 1, 0))
        if isinstance(self.high, float):
            return max(Fraction(math.ceil(self.low)) + 1, Fraction(1))
        middle, room = (self.low + self.high) / 2, (self.high - self.low) / 4
        if room > 2:  # wide interval: a value near 0 is the most natural
            middle, room = min(max(Fraction(0), self.low + 2), self.high - 2), Fraction(1)
        for digits in range(18):
            value = Fraction(round(middle, digits))
            if abs(value - middle) <= room:
                return value
        return middle


def solution(rows: Sequence[Row], spans: Mapping[int, Span], effort: Effort) -> tuple[dict[int, Fraction] | None, int]:
    """Find finite values of the variables that satisfy all inequalities.

    Returns:
        Value of each variable, and 0. If there is no solution: None, and the bit set of search decisions that exclude
        one.

    Raises:
        Exhausted: The step budget is exhausted.
    """
    tableau = _Tableau(rows, spans)
    while (violated := tableau.violated()) is not None:
        effort.spend(sum(len(row) for row in tableau.rows.values()) // 6 + 1)
        why = tableau.repair(violated)
        if why is not None:
            return None, why
    return _simplified(tableau.concrete(), rows, spans), 0


_Value = tuple[Fraction, Fraction]  # (a, b), which means a + b*epsilon
_Limit = tuple[_Value, int]  # a bound, and the bit set of search decisions from which it follows


class _Tableau:
    """Simplex tableau: each basic variable as a linear sum of the nonbasic variables.

    The slack variable of inequality i, which is the sum of its terms, has the number -1 - i.
    """

    def __init__(self, rows: Sequence[Row], spans: Mapping[int, Span]) -> None:
        self._low: dict[int, _Limit] = {}
        self._high: dict[int, _Limit] = {}
        self.values: dict[int, _Value] = {}  # those of nonbasic variables are always within their bounds
        for var in {var: None for row in rows for var in row.terms}:
            span = spans[var]
            if not isinstance(span.low, float):
                self._low[var] = (span.low, Fraction(span.above)), span.low_why
            if not isinstance(span.high, float):
                self._high[var] = (span.high, -Fraction(span.under)), span.high_why
            self.values[var] = self._clamped(var, (Fraction(0), Fraction(0)))
        self.rows = {-1 - i: {var: Fraction(f) for var, f in row.terms.items()} for i, row in enumerate(rows)}
        for i, row in enumerate(rows):
            self._high[-1 - i] = (-row.constant, -Fraction(row.strict)), row.why
            self.values[-1 - i] = self._sum(row.terms)

    def violated(self) -> int | None:
        """Lowest of the basic variables out of bounds, or None. Choosing the lowest ensures termination (Bland)."""
        return min((var for var in self.rows if self._clamped(var, self.values[var]) != self.values[var]), default=None)

    def repair(self, var: int) -> int | None:
        """Move a basic variable to the bound that it violates.

        Returns:
            None, or the bit set of search decisions that make the move impossible.
        """
        up = var in self._low and self.values[var] < self._low[var][0]
        bound, why = (self._low if up else self._high)[var]
        for other in sorted(self.rows[var]):
            limit = self._limit(other, (self.rows[var][other] > 0) is up)
            if limit is None or self.values[other] != limit[0]:
                self._exchange(var, other, bound)
                return None
            why |= limit[1]
        return why

    def concrete(self) -> dict[int, Fraction]:
        """Values of the variables as plain fractions, with epsilon so small that all bounds still hold."""
        amount = Fraction(1)
        for limits, sign in ((self._low, 1), (self._high, -1)):
            for var, (limit, _) in limits.items():
                room, loss = (sign * (v - b) for v, b in zip(self.values[var], limit, strict=True))
                if loss < 0 < room:
                    amount = min(amount, room / -loss)
        return {var: number + amount / 2 * extra for var, (number, extra) in self.values.items() if var >= 0}

    def _limit(self, var: int, upper: bool) -> _Limit | None:
        return (self._high if upper else self._low).get(var)

    def _clamped(self, var: int, value: _Value) -> _Value:
        """Clamp a value to the bounds of a variable."""
        if var in self._low:
            value = max(value, self._low[var][0])
        return min(value, self._high[var][0]) if var in self._high else value

    def _sum(self, terms: Mapping[int, Fraction | int]) -> _Value:
        return (
            sum((factor * self.values[var][0] for var, factor in terms.items()), Fraction(0)),
            sum((factor * self.values[var][1] for var, factor in terms.items()), Fraction(0)),
        )

    def _exchange(self, basic: int, other: int, value: _Value) -> None:
        """Pivot: set a basic variable to a value and exchange its role with that of a nonbasic variable."""
        row = self.rows.pop(basic)
        factor = row.pop(other)
        step = tuple((a - b) / factor for a, b in zip(value, self.values[basic], strict=True))
        solved = {var: -f / factor for var, f in row.items()} | {basic: 1 / factor}
        self.values[basic] = value
        self.values[other] = (self.values[other][0] + step[0], self.values[other][1] + step[1])
        for var, terms in self.rows.items():
            if (times := terms.pop(other, None)) is None:
                continue
            self.values[var] = (self.values[var][0] + times * step[0], self.values[var][1] + times * step[1])
            for each, f in solved.items():
                total = terms.get(each, Fraction(0)) + times * f
                if total:
                    terms[each] = total
                else:
                    del terms[each]
        self.rows[other] = solved


def _simplified(values: dict[int, Fraction], rows: Sequence[Row], spans: Mapping[int, Span]) -> dict[int, Fraction]:
    """Change a solution to values with few digits, away from the bounds.

    The variables are changed one after the other. Each stays in the interval that the inequalities allow for the
    present values of the others.
    """
    for var in values:
        span = spans[var]
        for row in rows:
            if var in row.terms:
                rest = row.constant + sum(f * values[v] for v, f in row.terms.items() if v != var)
                span = span.cut(-rest / row.terms[var], row.terms[var] > 0, row.strict)
        picked = span.pick()
        values[var] = picked if isinstance(picked, Fraction) else values[var]
    return values
