"""Formulas that the solver can decide: comparisons of linear sums with 0, joined by `and` and `or`.

A variable is an integer: the index of a value in the snapshot, or a number that is assigned to a subexpression. An
undetermined truth value is also a variable; it is true if at least 1 and false if at most 0. Coefficients are exact
fractions, so no answer depends on rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, reduce
from operator import or_
from typing import TypeAlias


class Undecided(Exception):
    """Raised if a question cannot be decided; the message is the reason, as shown to the user."""


class Exhausted(Undecided):
    """Raised if the step budget is exhausted."""


class Effort:
    """Budget of solver steps for each question, and for all questions together. A step takes about 20 us."""

    def __init__(self, each: int, total: int) -> None:
        self._each, self._total = each, total
        self._now, self._left = each, total

    def begin(self) -> None:
        """Start a new question, with the full number of steps per question."""
        self._now = self._each

    def spend(self, steps: int = 1) -> None:
        """Consume steps.

        Raises:
            Exhausted: Not enough steps are left.
        """
        self._now -= steps
        self._left -= steps
        if self._left < 0:
            raise Exhausted(f"all questions about the rules together take more than {self._total} steps")
        if self._now < 0:
            raise Exhausted(f"it takes more than {self._each} steps")


@dataclass(frozen=True)
class Bound:
    """Formula `variable <= value` or `variable >= value`; `<` or `>` if `strict`."""

    var: int
    upper: bool  # else a lower bound
    value: Fraction | float  # a float only if infinite
    strict: bool

    @property
    def vars(self) -> int:
        """Bit set of the variables in the formula."""
        return 1 << self.var


@dataclass(frozen=True)
class Row:
    """Linear inequality of several variables: terms + constant < 0, or <= 0 unless `strict`."""

    terms: Mapping[int, int]  # nonzero integers without a common divisor
    constant: Fraction
    strict: bool
    why: int = 0  # bit set of the search decisions from which it follows

    @cached_property
    def vars(self) -> int:
        """Bit set of the variables in the formula."""
        return sum(1 << var for var in self.terms)


@dataclass(frozen=True)
class Join:
    """Conjunction or disjunction of formulas."""

    every: bool  # conjunction; else disjunction
    parts: tuple[Formula, ...]
    defines: int = -1  # variable that each alternative of a disjunction bounds; -1 for none

    @cached_property
    def vars(self) -> int:
        """Bit set of the variables in the formula."""
        return reduce(or_, (part.vars for part in self.parts), 0)


Formula: TypeAlias = Bound | Row | Join
TRUE, FALSE = Join(True, ()), Join(False, ())


def join(every: bool, parts: Iterable[Formula], defines: int = -1) -> Formula:
    """Simplified conjunction of formulas if `every` is True, else their simplified disjunction."""
    neutral, decided = (TRUE, FALSE) if every else (FALSE, TRUE)
    flat: list[Formula] = []
    for part in parts:
        if part == decided:
            return decided
        if isinstance(part, Join) and part.every is every:
            flat += part.parts
        elif part != neutral:
            flat.append(part)
    return flat[0] if len(flat) == 1 else Join(every, tuple(flat), defines)


def below_zero(
    terms: Mapping[int, Fraction], constant: Fraction | float, strict: bool, finite: Callable[[int], bool]
) -> Formula:
    """Formula `sum of the terms + constant < 0`, or `<= 0` unless `strict`.

    Raises:
        Undecided: Infinite numbers of opposite signs can occur in the sum.
    """
    terms = {var: factor for var, factor in terms.items() if factor}
    if isinstance(constant, float):
        return _with_infinity(terms, constant, strict, finite)
    if not terms:
        return TRUE if constant < 0 or (constant == 0 and not strict) else FALSE
    if len(terms) > 1:
        scale = Fraction(math.lcm(*(f.denominator for f in terms.values())))
        scale /= math.gcd(*(int(f * scale) for f in terms.values()))
        return Row({var: int(f * scale) for var, f in terms.items()}, constant * scale, strict)
    ((var, factor),) = terms.items()
    value = -constant / factor
    return Bound(var, factor > 0, value, strict)


def _with_infinity(
    terms: Mapping[int, Fraction], constant: float, strict: bool, finite: Callable[[int], bool]
) -> Formula:
    if math.isnan(constant):
        raise Undecided("infinite numbers are subtracted from each other")
    if all(finite(var) for var in terms):
        return TRUE if constant < 0 else FALSE
    if len(terms) > 1:
        raise Undecided("several signals are compared with an infinite number")
    ((var, factor),) = terms.items()
    if constant < 0:  # compares the sum with +inf
        return Bound(var, factor > 0, math.inf if factor > 0 else -math.inf, True) if strict else TRUE
    return FALSE if strict else Bound(var, factor > 0, -math.inf if factor > 0 else math.inf, False)
