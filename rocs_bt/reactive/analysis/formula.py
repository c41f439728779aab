"""What a guard says in a form that can be decided: comparisons of linear sums with 0, joined by and, or.

A variable is an index of the snapshot, or the number that stands for a part of an expression. A truth value of which
nothing is known is a variable too: at least 1, or at most 0. Numbers are exact fractions, so that nothing is decided by
rounding.
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
    """Why a question cannot be decided, for people."""


class Exhausted(Undecided):
    """Deciding takes more steps than there are."""


class Effort:
    """Steps that may be taken: for one question, and for all of them together. A step takes about 20 microseconds.

    Args:
        each: For a question.
        total: For all of them.
    """

    def __init__(self, each: int, total: int) -> None:
        self._each, self._total = each, total
        self._now, self._left = each, total

    def begin(self) -> None:
        """A new question."""
        self._now = self._each

    def spend(self, steps: int = 1) -> None:
        """Take some steps.

        Raises:
            Exhausted: There were not so many left.
        """
        self._now -= steps
        self._left -= steps
        if self._left < 0:
            raise Exhausted(f"all questions about the rules together take more than {self._total} steps")
        if self._now < 0:
            raise Exhausted(f"it takes more than {self._each} steps")


@dataclass(frozen=True)
class Bound:
    """A variable is less, or greater, than a number.

    Attributes:
        var: The variable.
        upper: True: less than; False: greater than.
        value: The number; a float only where it is infinite.
        strict: Whether equal will not do.
    """

    var: int
    upper: bool
    value: Fraction | float
    strict: bool

    @property
    def vars(self) -> int:
        """The variables as bits."""
        return 1 << self.var


@dataclass(frozen=True)
class Row:
    """A linear sum of several variables is less than 0.

    Attributes:
        terms: The factor of each variable; whole numbers without a common divisor, none is 0.
        constant: What is added.
        strict: Whether equal to 0 will not do.
        why: The decisions of the search from which it follows, as bits.
    """

    terms: Mapping[int, int]
    constant: Fraction
    strict: bool
    why: int = 0

    @cached_property
    def vars(self) -> int:
        """The variables as bits."""
        return sum(1 << var for var in self.terms)


@dataclass(frozen=True)
class Join:
    """Several formulas: all of them hold, or at least one does.

    Attributes:
        every: Whether all of them hold.
        parts: The formulas.
        defines: The variable that all of them bound; -1 for none.
    """

    every: bool
    parts: tuple[Formula, ...]
    defines: int = -1

    @cached_property
    def vars(self) -> int:
        """The variables as bits."""
        return reduce(or_, (part.vars for part in self.parts), 0)


Formula: TypeAlias = Bound | Row | Join
TRUE, FALSE = Join(True, ()), Join(False, ())


def join(every: bool, parts: Iterable[Formula], defines: int = -1) -> Formula:
    """The formulas joined by and, or, with what is plain taken out."""
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
    """The formula of a linear sum that is less than 0.

    Args:
        terms: The factor of each variable.
        constant: What is added, perhaps infinite.
        strict: Whether equal to 0 will not do.
        finite: Whether a variable can only be finite.

    Raises:
        Undecided: Infinite numbers meet in it.
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
    if constant < 0:  # the sum is less than inf
        return Bound(var, factor > 0, math.inf if factor > 0 else -math.inf, True) if strict else TRUE
    return FALSE if strict else Bound(var, factor > 0, -math.inf if factor > 0 else math.inf, False)
