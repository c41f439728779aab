# ruff: noqa: D103  # a function for each operator; the table of operators describes them
"""Meaning of operators in z3: the column `z3` of the table of operators.

A number is real, infinite or invalid, and a truth value is true, false or invalid, as on a robot. Two things are not
exact: numbers are not rounded, and of `atan2` and the temporal operators only a part of the meaning is known. So if no
solution exists, the expression is never true; but a solution is only a candidate.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Protocol, TypeAlias

Term: TypeAlias = Any  # a term of z3, which has no annotations, or a bool if it is constant


@dataclass(frozen=True)
class Number:
    """Number: +infinite (`over`), -infinite (`under`), invalid (`bad`), else `real`."""

    real: Term
    over: Term = False
    under: Term = False
    bad: Term = False

    @property
    def infinite(self) -> Term:
        """Whether the number is infinite."""
        return any_of(self.over, self.under)


@dataclass(frozen=True)
class Truth:
    """Truth value: `true`, or invalid if it is not `valid`."""

    true: Term
    valid: Term = True

    @property
    def false(self) -> Term:
        """Whether the value is false."""
        return no(self.true) if self.valid is True else all_of(self.valid, no(self.true))


@dataclass(frozen=True, eq=False)
class Condition:
    """Condition on the variables that a term contains.

    Attributes:
        term: The condition.
        steady: Whether it is sure only if all signals have been constant for longer than all time windows.
        unknown: Source text of the subexpression of which it is not the whole meaning; empty if it is.
    """

    term: Term
    steady: bool = False
    unknown: str = ""


@dataclass(frozen=True, eq=False)
class Clip(Condition):
    """Clipped number, with the number itself and the limits."""

    found: Term = None
    whole: Number = Number(None)
    limits: tuple[float, ...] = ()

    def divided(self, mark: float) -> Term:
        """A constant between the limits divides the clipped number as it divides the number itself.

        This follows from the definition, but without it a sum of n clipped numbers needs 2**n cases.
        """
        if not self.limits[0] < mark < self.limits[1]:
            return True
        at = exact(mark, self.found.ctx)
        more = any_of(self.whole.under, self.found >= at, self.whole.real <= at)
        return all_of(more, any_of(self.whole.over, self.found <= at, self.whole.real >= at))


class Question(Protocol):
    """Expression that is being translated: source of new variables, and receiver of conditions on them."""

    context: Any

    def number(self, value: float) -> Number:
        """Constant."""
        ...

    def real(self) -> Term:
        """New variable for a real number."""
        ...

    def flag(self) -> Term:
        """New variable for a truth value."""
        ...

    def require(self, condition: Condition | Term, steady: bool = False, partly: bool = False) -> None:
        """Add a condition on variables.

        Args:
            condition: The condition.
            steady: Whether it is sure only for constant signals; see `Condition`.
            partly: Whether it is not the whole meaning of the operator.
        """
        ...


def _z3() -> Any:
    import z3  # here, because it takes 40 ms

    return z3


def all_of(*parts: Term) -> Term:
    """Conjunction."""
    left = [part for part in parts if part is not True]
    if any(part is False for part in left):
        return False
    return _z3().And(left) if len(left) > 1 else left[0] if left else True


def any_of(*parts: Term) -> Term:
    """Disjunction."""
    left = [part for part in parts if part is not False]
    if any(part is True for part in left):
        return True
    return _z3().Or(left) if len(left) > 1 else left[0] if left else False


def no(part: Term) -> Term:
    """Negation."""
    return not part if isinstance(part, bool) else _z3().Not(part)


def choice(test: Term, a: Term, b: Term) -> Term:
    """`a` if the test is true, else `b`."""
    if isinstance(test, bool):
        return a if test else b
    if isinstance(a, bool) or isinstance(b, bool):
        return any_of(all_of(test, a), all_of(no(test), b))
    return _z3().If(test, a, b)


def conjunction(t: Question, *groups: Any) -> Truth:
    """Conjunction in three-valued logic."""
    truths = _flat(*groups)
    return Truth(all_of(*(each.true for each in truths)), _decided(truths, (each.false for each in truths)))


def disjunction(t: Question, *groups: Any) -> Truth:
    """Disjunction in three-valued logic."""
    truths = _flat(*groups)
    return Truth(any_of(*(each.true for each in truths)), _decided(truths, (each.true for each in truths)))


def _decided(truths: Sequence[Truth], deciding: Iterable[Term]) -> Term:
    """Whether all truth values are valid, or one decides the result whatever the others are."""
    valid = all_of(*(each.valid for each in truths))
    return valid if valid is True else any_of(valid, *deciding)


def negated(truth: Truth) -> Truth:
    """Negation in three-valued logic."""
    return Truth(truth.false, truth.valid)


def below(a: Number, b: Number, sign: str) -> Truth:
    """`a < b` or `a <= b`."""
    if sign == "<=":
        return negated(below(b, a, "<"))
    valid = no(any_of(a.bad, b.bad))
    if a.infinite is False and b.infinite is False:
        return Truth(all_of(valid, a.real < b.real), valid)
    finite = no(any_of(a.infinite, b.infinite))
    less = any_of(all_of(finite, a.real < b.real), all_of(a.under, no(b.under)), all_of(b.over, no(a.over)))
    return Truth(all_of(valid, less), valid)


def less(t: Question, a: Number, b: Number) -> Truth:
    return below(a, b, "<")


def less_or_equal(t: Question, a: Number, b: Number) -> Truth:
    return below(a, b, "<=")


def equal(t: Question, a: Number, b: Number) -> Truth:
    return conjunction(t, below(a, b, "<="), below(b, a, "<="))


def different(t: Question, a: Number, b: Number) -> Truth:
    return negated(equal(t, a, b))


def _flat(*values: Any) -> list[Any]:
    return [v for value in values for v in (value if isinstance(value, list) else [value])]


def bad_of(*numbers: Number) -> Term:
    return any_of(*(n.bad for n in numbers))


def is_constant(real: Term) -> bool:
    return bool(_z3().is_rational_value(real))


def to_float(real: Term) -> float:
    fraction = real.as_fraction()
    try:
        return float(fraction)
    except OverflowError:
        return math.inf if fraction > 0 else -math.inf


def exact(value: float, context: Any) -> Term:
    """The decimal number: 1/10 for 0.1, of which z3 needs fewer digits than of the nearest float."""
    return _z3().RealVal(Fraction(repr(value)), context)


def negative(a: Number) -> Number:
    return Number(-a.real, a.under, a.over, a.bad)


def total(t: Question, *groups: Any) -> Number:
    numbers = _flat(*groups)
    over, under = any_of(*(n.over for n in numbers)), any_of(*(n.under for n in numbers))
    real = _z3().Sum([n.real for n in numbers]) if len(numbers) > 1 else numbers[0].real
    bad = any_of(bad_of(*numbers), all_of(over, under))
    return Number(real, over, under, bad)


def difference(t: Question, a: Number, b: Number) -> Number:
    return total(t, a, negative(b))


def dot(t: Question, group: Any, vector: Any) -> Number:
    return total(t, *(product(t, a, b) for a, b in zip(_flat(group), _flat(vector), strict=True)))


def mean(t: Question, group: Any) -> Number:
    found = total(t, group)
    return replace(found, real=found.real / len(_flat(group)))


def clip(t: Question, a: Number, low: Number, high: Number) -> Number:
    ends = (low, high)
    limits = tuple(to_float(n.real) for n in ends if is_constant(n.real) and any_of(n.infinite, n.bad) is False)
    if len(limits) < 2 or limits[0] > limits[1]:
        return least(t, greatest(t, a, low), high)
    found = t.real()
    more = any_of(all_of(no(a.infinite), found >= a.real), a.under, found >= high.real)
    less = any_of(all_of(no(a.infinite), found <= a.real), a.over, found <= low.real)
    t.require(Clip(all_of(found >= low.real, found <= high.real, more, less), False, "", found, a, limits))
    return Number(found, bad=a.bad)


def least(t: Question, *groups: Any) -> Number:
    """Minimum: at most each number, and at least one of them."""
    numbers = _flat(*groups)
    if len(numbers) == 1:
        (only,) = numbers
        return Number(only.real, only.over, only.under, only.bad)
    real = t.real()
    over, under = all_of(*(n.over for n in numbers)), any_of(*(n.under for n in numbers))
    for n in numbers:
        t.require(any_of(n.over, under, real <= n.real))
    t.require(any_of(over, under, *(all_of(no(n.over), real >= n.real) for n in numbers)))
    return Number(real, over, under, bad_of(*numbers))


def greatest(t: Question, *groups: Any) -> Number:
    return negative(least(t, *map(negative, _flat(*groups))))


def _signs(t: Question, a: Number) -> tuple[Term, Term]:
    """Whether a number is positive, and whether it is negative."""
    if is_constant(a.real) and a.infinite is False:
        return to_float(a.real) > 0.0, to_float(a.real) < 0.0
    zero = t.number(0.0)
    return below(zero, a, "<").true, below(a, zero, "<").true


def product(t: Question, a: Number, b: Number) -> Number:
    if a.infinite is False and b.infinite is False:
        return Number(_product(a.real, b.real), bad=bad_of(a, b))
    (a_up, a_down), (b_up, b_down) = _signs(t, a), _signs(t, b)
    infinite = any_of(a.infinite, b.infinite)
    over = all_of(infinite, any_of(all_of(a_up, b_up), all_of(a_down, b_down)))
    under = all_of(infinite, any_of(all_of(a_up, b_down), all_of(a_down, b_up)))
    bad = any_of(bad_of(a, b), all_of(infinite, no(any_of(over, under))))
    return Number(_product(a.real, b.real), over, under, bad)


def _product(a: Term, b: Term) -> Term:
    """Product; of a term with few constant values, such as `side(a)`, by cases, so that it is linear."""
    if is_constant(a) or is_constant(b):
        return a * b
    for switch, other in ((a, b), (b, a)):
        if _switched(switch):
            if _z3().is_add(switch):
                return _z3().Sum([_product(part, other) for part in switch.children()])
            test, then, otherwise = switch.children()
            return _z3().If(test, _product(then, other), _product(otherwise, other))
    return a * b


def _switched(term: Term) -> bool:
    """Whether a term can have only few constant values."""
    if is_constant(term):
        return True
    if _z3().is_app_of(term, _z3().Z3_OP_ITE):
        return all(_switched(part) for part in term.children()[1:])
    return bool(_z3().is_add(term)) and all(_switched(part) for part in term.children())


def quotient(t: Question, a: Number, b: Number) -> Number:
    up, down = _signs(t, b)
    over, under = any_of(all_of(a.over, up), all_of(a.under, down)), any_of(all_of(a.over, down), all_of(a.under, up))
    bad = any_of(bad_of(a, b), no(any_of(up, down)), all_of(a.infinite, b.infinite))
    return Number(choice(b.infinite, t.number(0.0).real, a.real / b.real), over, under, bad)


def select(t: Question, a: Any, b: Any, test: Truth) -> Any:
    if isinstance(a, Truth):
        true = any_of(all_of(test.true, a.true), all_of(test.false, b.true))
        return Truth(true, all_of(test.valid, choice(test.true, a.valid, b.valid)))
    bad = any_of(no(test.valid), choice(test.true, a.bad, b.bad))
    over, under = choice(test.true, a.over, b.over), choice(test.true, a.under, b.under)
    return Number(choice(test.true, a.real, b.real), over, under, bad)


def sign(t: Question, a: Number) -> Number:
    up, down = _signs(t, a)
    zero, one = t.number(0.0).real, t.number(1.0).real
    return Number(choice(up, one, choice(down, -one, zero)), bad=a.bad)


def side(t: Question, a: Number) -> Number:
    _, down = _signs(t, a)
    return Number(choice(down, t.number(-1.0).real, t.number(1.0).real), bad=a.bad)


def count(t: Question, group: Any) -> Number:
    truths = _flat(group)
    one, zero = t.number(1.0).real, t.number(0.0).real
    invalid = any_of(*(no(each.valid) for each in truths))
    return Number(_z3().Sum([choice(each.true, one, zero) for each in truths]), bad=invalid)


def argmin(t: Question, group: Any) -> Number:
    numbers = _flat(group)
    lowest, index = least(t, numbers), t.number(len(numbers) - 1.0).real
    for i in reversed(range(len(numbers) - 1)):
        index = choice(below(numbers[i], lowest, "<=").true, t.number(float(i)).real, index)
    return Number(index, bad=lowest.bad)


def min_valid(t: Question, group: Any, enough: Number) -> Number:
    found = least(t, group)
    return found if found.bad is False else Number(t.real(), t.flag(), t.flag(), t.flag())


def sqrt(t: Question, a: Number) -> Number:
    root, (_, below_zero) = t.real(), _signs(t, a)
    t.require(any_of(a.infinite, a.real < 0, all_of(root >= 0, root * root == a.real)))
    return Number(root, a.over, False, any_of(a.bad, below_zero))


def hypot(t: Question, a: Number, b: Number) -> Number:
    length = t.real()
    t.require(all_of(length >= 0, length * length == a.real * a.real + b.real * b.real))
    sizes = [_z3().If(n.real < 0, -n.real, n.real) for n in (a, b)]
    t.require(all_of(*(length >= size for size in sizes), length <= _z3().Sum(sizes)))
    return Number(length, any_of(a.infinite, b.infinite), False, bad_of(a, b))


def wrap_angle(t: Question, a: Number) -> Number:
    turns, angle, half = _z3().ToReal(_z3().Int(f"{t.real()}", t.context)), t.real(), t.number(math.pi).real
    t.require(all_of(angle == a.real - 2 * half * turns, angle >= -half, angle <= half))
    return Number(angle, bad=any_of(a.bad, a.infinite))


def absolute(t: Question, a: Number) -> Number:
    return greatest(t, a, negative(a))


def atan2(t: Question, y: Number, x: Number) -> Number:
    angle, half = t.real(), t.number(math.pi).real
    t.require(all_of(angle >= -half, angle <= half), partly=True)
    return Number(angle, bad=bad_of(x, y))


def _literal(t: Question, steady: Truth) -> Term:
    """Unknown truth value, equal to another one if all signals are steady."""
    found = t.flag()
    t.require(found == steady.true, steady=True, partly=True)
    return found


def held(t: Question, a: Truth) -> Truth:
    before = _literal(t, a)
    return Truth(all_of(before, a.true), any_of(a.true, no(before)))


def once(t: Question, a: Truth) -> Truth:
    before = _literal(t, a)
    return Truth(before, any_of(before, a.false))


def since(t: Question, a: Truth, b: Truth) -> Truth:
    before = _literal(t, b)
    true = all_of(before, any_of(a.true, b.true))
    return Truth(true, any_of(true, all_of(no(before), b.false)))


def time_since(t: Question, a: Truth) -> Number:
    time, never = t.real(), t.flag()
    t.require(time >= 0, partly=True)
    t.require(choice(a.true, all_of(time == 0, no(never)), never), steady=True)
    return Number(time, never)


def rate(t: Question, a: Number) -> Number:
    """Rate, never invalid: what an invalid rate makes true is true for each rate, since no operator prefers invalid."""
    found = Number(t.real(), t.flag(), t.flag())
    t.require(no(all_of(found.over, found.under)), partly=True)
    t.require(all_of(found.real == 0, no(found.infinite)), steady=True)
    return found
