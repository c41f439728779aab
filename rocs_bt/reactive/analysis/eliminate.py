"""Whether linear inequalities have a solution, exactly, by Fourier-Motzkin elimination.

Source: A. Schrijver, "Theory of Linear and Integer Programming" (1986), section 12.2. Rules compare few signals with
each other, so the inequalities are few; many are refused.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from .formula import Effort, Row


@dataclass(frozen=True)
class Span:
    """What a variable can be.

    Attributes:
        low: The least value.
        high: The greatest value.
        above: Whether `low` itself is left out.
        under: Whether `high` itself is left out.
    """

    low: Fraction | float = -math.inf
    high: Fraction | float = math.inf
    above: bool = False
    under: bool = False

    @property
    def empty(self) -> bool:
        """Whether there is no such value."""
        return self.low > self.high or (self.low == self.high and (self.above or self.under))

    def __contains__(self, value: Fraction | float) -> bool:
        over = value > self.low or (value == self.low and not self.above)
        return over and (value < self.high or (value == self.high and not self.under))

    def cut(self, value: Fraction | float, upper: bool, strict: bool) -> Span:
        """The part of it that is less, or greater, than a value."""
        if upper and (value < self.high or (value == self.high and strict)):
            return Span(self.low, value, self.above, strict)
        if not upper and (value > self.low or (value == self.low and strict)):
            return Span(value, self.high, strict, self.under)
        return self

    def pick(self) -> Fraction | float:
        """A value of it that is short to write, away from its ends where there is room."""
        if self.low == self.high:
            return self.low
        if math.isinf(self.low) and math.isinf(self.high):
            return 0
        if math.isinf(self.low):
            return min(Fraction(math.floor(self.high)) - 1, Fraction(0))
        if math.isinf(self.high):
            return max(Fraction(math.ceil(self.low)) + 1, Fraction(1))
        middle, room = Fraction(self.low + self.high) / 2, Fraction(self.high - self.low) / 4
        for digits in range(18):
            value = Fraction(round(middle, digits))
            if abs(value - middle) <= room:
                return value
        return middle


def solution(rows: Sequence[Row], spans: Mapping[int, Span], effort: Effort) -> dict[int, Fraction | float] | None:
    """Finite values of the rows' variables with which all rows hold; None where there are none.

    Args:
        rows: The inequalities.
        spans: What each of their variables can be.
        effort: What it may take.

    Raises:
        Undecided: It takes more.
    """
    system = [*rows, *(row for var in {v for r in rows for v in r.terms} for row in _ends(var, spans[var]))]
    steps: list[tuple[int, list[Row]]] = []
    while True:
        if any(not _plain(row) for row in system if not row.terms):
            return None
        system = [row for row in system if row.terms]
        if not system:
            return _values(steps, spans)
        var = min({v for row in system for v in row.terms}, key=lambda v: (_cost(system, v), v))
        steps.append((var, [row for row in system if var in row.terms]))
        system = _without(system, var, effort)


def _ends(var: int, span: Span) -> list[Row]:
    found = []
    if not math.isinf(span.low):
        found.append(Row({var: Fraction(-1)}, Fraction(span.low), span.above))
    if not math.isinf(span.high):
        found.append(Row({var: Fraction(1)}, -Fraction(span.high), span.under))
    return found


def _plain(row: Row) -> bool:
    return row.constant < 0 or (row.constant == 0 and not row.strict)


def _cost(system: Sequence[Row], var: int) -> int:
    signs = [row.terms[var] > 0 for row in system if var in row.terms]
    return sum(signs) * (len(signs) - sum(signs)) - len(signs)


def _without(system: Sequence[Row], var: int, effort: Effort) -> list[Row]:
    """What follows for the others: each row that bounds the variable from above with each from below."""
    kept: dict[tuple[tuple[int, Fraction], ...], Row] = {}

    def keep(row: Row) -> None:
        # Of rows with the same sum only the tightest matters.
        scale = abs(next(iter(row.terms.values()))) if row.terms else Fraction(1)
        terms = {v: f / scale for v, f in sorted(row.terms.items())}
        scaled = Row(terms, row.constant / scale, row.strict)
        key = tuple(terms.items())
        old = kept.get(key)
        if old is None or (scaled.constant, scaled.strict) > (old.constant, old.strict):
            kept[key] = scaled

    above = [row for row in system if row.terms.get(var, 0) > 0]
    below = [row for row in system if row.terms.get(var, 0) < 0]
    for row in system:
        if var not in row.terms:
            keep(row)
    effort.spend(len(system) + 4 * len(above) * len(below))
    for up in above:
        for down in below:
            keep(_sum(up, -1 / down.terms[var], down, 1 / up.terms[var], var))
    return list(kept.values())


def _sum(up: Row, down_scale: Fraction, down: Row, up_scale: Fraction, var: int) -> Row:
    terms = {v: f * up_scale for v, f in up.terms.items()}
    for v, f in down.terms.items():
        terms[v] = terms.get(v, Fraction(0)) + f * down_scale
    terms = {v: f for v, f in terms.items() if f and v != var}
    return Row(terms, up.constant * up_scale + down.constant * down_scale, up.strict or down.strict)


def _values(steps: Sequence[tuple[int, list[Row]]], spans: Mapping[int, Span]) -> dict[int, Fraction | float]:
    """Values from the variable that was eliminated last to the first, each within what the others leave it."""
    values: dict[int, Fraction | float] = {}
    for var, rows in reversed(steps):
        span = Span()
        for row in rows:
            rest = row.constant + sum(
                (f * Fraction(_known(values, spans, v)) for v, f in row.terms.items() if v != var), Fraction(0)
            )
            span = span.cut(-rest / row.terms[var], row.terms[var] > 0, row.strict)
        values[var] = span.pick()
    return values


def _known(values: dict[int, Fraction | float], spans: Mapping[int, Span], var: int) -> Fraction | float:
    """The value of a variable; one that fell out of all inequalities may have any."""
    if var not in values:
        values[var] = spans[var].pick()
    return values[var]
