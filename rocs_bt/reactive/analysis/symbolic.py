"""Expressions as terms of z3. Only this module imports z3, and only the first proof imports this module.

A number is real, infinite or invalid, and a truth value is true, false or invalid, as on a robot. Two things are not
exact: numbers are not rounded, and of `atan2` and the temporal operators only a part of the meaning is known. So if no
solution exists, the expression is never true; but a solution is only a candidate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, TypeAlias

import z3

from ...expression import Kind, Node, evaluate
from .sample import Array

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
class _Clip(Condition):
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
        at = _exact(mark, self.found.ctx)
        more = any_of(self.whole.under, self.found >= at, self.whole.real <= at)
        return all_of(more, any_of(self.whole.over, self.found <= at, self.whole.real >= at))


@dataclass(frozen=True)
class Solution:
    """Result of a search for values.

    Attributes:
        x: Snapshot that satisfies all that is known of the expression; None if none was found.
        never: Whether it is proved that there is none.
        steps: Steps of z3 that it took.
        unknown: Source texts of subexpressions of which only a part of the meaning is known.
    """

    x: Array | None
    never: bool
    steps: int
    unknown: tuple[str, ...]


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
        solver.add(*(c.divided(mark) for c in conditions if isinstance(c, _Clip) for mark in sorted(marks)))
        found = solver.check()
        self._steps = solver.statistics().get_key_value("rlimit count")
        x = self._snapshot(solver.model(), free) if found == z3.sat else None
        solver.pop()
        return Solution(x, found == z3.unsat, self._steps - before, unknown)

    def _snapshot(self, model: z3.ModelRef, free: Array) -> Array:
        x = free.copy()
        for index, signal in self._signals.items():
            over, under = (z3.is_expr(end) and z3.is_true(model[end]) for end in (signal.over, signal.under))
            found = model[signal.real]
            if over or under:
                x[index] = math.inf if over else -math.inf
            elif found is not None:
                x[index] = _float(found.approx(20) if z3.is_algebraic_value(found) else found)
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
        """Constant."""
        if value not in self._constants:
            real = _exact(value if math.isfinite(value) else 0.0, self.context)
            self._constants[value] = Number(real, value == math.inf, value == -math.inf, math.isnan(value))
        return self._constants[value]

    def real(self) -> Term:
        """New variable for a real number."""
        self._variables += 1
        return z3.Real(f"r{self._variables}", self.context)

    def flag(self) -> Term:
        """New variable for a truth value."""
        self._variables += 1
        return z3.Bool(f"b{self._variables}", self.context)

    def require(self, condition: Condition | Term, steady: bool = False, unknown: str = "") -> None:
        """Add a condition on variables; see `Condition`."""
        if not isinstance(condition, Condition):
            condition = Condition(condition, steady, unknown)
        self._conditions[condition] = None

    def _new(self, node: Node) -> Any:
        args = node.args
        if node.kind.size:
            return [self.value(element(node, i)) for i in range(node.kind.size)]
        if node.op == "read":
            return self._signal(node.start)
        if node.op == "truth":
            return Truth(bool(node.value))
        if node.constant and not node.kind.boolean:
            value = evaluate(node, ())
            return self.number(math.nan if value is None else value)
        if node.op == "compare":
            return every(*(self._compared(pair.args[0], pair.args[1], pair.signs[0]) for pair in node.pairs))
        if node.op in _NAMED:
            return _NAMED[node.op](self, node.text, *map(self.value, args))
        row = _ROWS.get(node.op)
        return self._unknown(node) if row is None else row(self, *map(self.value, args))

    def _unknown(self, node: Node) -> Number | Truth:
        """Any value, of an operator without a row: it is never wrong, but a proof may need a row."""
        if node.kind.boolean:
            truth = Truth(self.flag(), self.flag())
            self.require(any_of(truth.valid, no(truth.true)), unknown=node.text)
            return truth
        number = Number(self.real(), self.flag(), self.flag(), self.flag())
        self.require(no(all_of(number.over, number.under)), unknown=node.text)
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

    def _compared(self, a: Node, b: Node, sign: str) -> Truth:
        """Comparison of two numbers. `min(a, b) < c` becomes `a < c or b < c`, which needs no variable."""
        if sign in (">", ">="):
            a, b, sign = b, a, {">": "<", ">=": "<="}[sign]
        if sign in ("<", "<="):
            for extreme, lesser in ((a, True), (b, False)):
                parts = [self.value(part) for part in _parts(extreme)]
                if not parts or (extreme.op == "min_valid" and _bad(*parts) is not False):
                    continue
                other = self.value(b if lesser else a)
                each = [_below(*((part, other) if lesser else (other, part)), sign) for part in parts]
                found = some(*each) if lesser is (extreme.op in ("min", "min_valid")) else every(*each)
                valid = all_of(*(t.valid for t in each))
                return Truth(all_of(valid, found.true), valid)
        x, y = self.value(a), self.value(b)
        if sign in ("<", "<="):
            return _below(x, y, sign)
        equal = every(_below(x, y, "<="), _below(y, x, "<="))
        return equal if sign == "==" else negated(equal)


def all_of(*parts: Term) -> Term:
    """Conjunction."""
    left = [part for part in parts if part is not True]
    if any(part is False for part in left):
        return False
    return z3.And(left) if len(left) > 1 else left[0] if left else True


def any_of(*parts: Term) -> Term:
    """Disjunction."""
    left = [part for part in parts if part is not False]
    if any(part is True for part in left):
        return True
    return z3.Or(left) if len(left) > 1 else left[0] if left else False


def no(part: Term) -> Term:
    """Negation."""
    return not part if isinstance(part, bool) else z3.Not(part)


def choice(test: Term, a: Term, b: Term) -> Term:
    """`a` if the test is true, else `b`."""
    if isinstance(test, bool):
        return a if test else b
    if isinstance(a, bool) or isinstance(b, bool):
        return any_of(all_of(test, a), all_of(no(test), b))
    return z3.If(test, a, b)


def every(*truths: Truth) -> Truth:
    """Conjunction in three-valued logic."""
    valid = all_of(*(t.valid for t in truths))
    if valid is not True:
        valid = any_of(valid, *(t.false for t in truths))
    return Truth(all_of(*(t.true for t in truths)), valid)


def some(*truths: Truth) -> Truth:
    """Disjunction in three-valued logic."""
    valid = all_of(*(t.valid for t in truths))
    if valid is not True:
        valid = any_of(valid, *(t.true for t in truths))
    return Truth(any_of(*(t.true for t in truths)), valid)


def negated(truth: Truth) -> Truth:
    """Negation in three-valued logic."""
    return Truth(truth.false, truth.valid)


def element(node: Node, i: int) -> Node:
    """Expression of the i-th value of an expression with a group of values; a single value is returned unchanged."""
    if not node.kind.size:
        return node
    if node.op == "vector":
        return node.args[i]
    kind = Kind(node.kind.dimension, 0, node.kind.boolean)
    if node.op == "read":
        return replace(node, kind=kind, start=node.start + i, stop=node.start + i + 1, text=f"{node.text}[{i}]")
    return replace(node, kind=kind, args=tuple(element(arg, i) for arg in node.args))


def _parts(node: Node) -> list[Node]:
    """Expressions of which a `min`, `max`, `min_valid` or `abs` is the minimum or maximum; none for other operators."""
    if node.op == "abs":
        (arg,) = node.args
        return [arg, Node("neg", arg.kind, (arg,), text=f"-({arg.text})")]
    if node.op not in ("min", "max", "min_valid") or node.constant:
        return []
    groups = node.args if node.op != "min_valid" else node.args[:1]
    return [element(group, i) for group in groups for i in range(max(1, group.kind.size))]


def _below(a: Number, b: Number, sign: str) -> Truth:
    """`a < b` or `a <= b`."""
    if sign == "<=":
        return negated(_below(b, a, "<"))
    valid = no(any_of(a.bad, b.bad))
    if a.infinite is False and b.infinite is False:
        return Truth(all_of(valid, a.real < b.real), valid)
    finite = no(any_of(a.infinite, b.infinite))
    less = any_of(all_of(finite, a.real < b.real), all_of(a.under, no(b.under)), all_of(b.over, no(a.over)))
    return Truth(all_of(valid, less), valid)


def _flat(*values: Any) -> list[Any]:
    return [v for value in values for v in (value if isinstance(value, list) else [value])]


def _bad(*numbers: Number) -> Term:
    return any_of(*(n.bad for n in numbers))


def _constant(real: Term) -> bool:
    return bool(z3.is_rational_value(real))


def _float(real: Term) -> float:
    fraction = real.as_fraction()
    try:
        return float(fraction)
    except OverflowError:
        return math.inf if fraction > 0 else -math.inf


def _exact(value: float, context: z3.Context) -> Term:
    """The decimal number: 1/10 for 0.1, of which z3 needs fewer digits than of the nearest float."""
    return z3.RealVal(Fraction(repr(value)), context)


def _negative(a: Number) -> Number:
    return Number(-a.real, a.under, a.over, a.bad)


def _total(t: Translator, *groups: Any) -> Number:
    numbers = _flat(*groups)
    over, under = any_of(*(n.over for n in numbers)), any_of(*(n.under for n in numbers))
    real = z3.Sum([n.real for n in numbers]) if len(numbers) > 1 else numbers[0].real
    bad = any_of(_bad(*numbers), all_of(over, under))
    return Number(real, over, under, bad)


def _mean(t: Translator, group: Any) -> Number:
    total = _total(t, group)
    return replace(total, real=total.real / len(_flat(group)))


def _clip(t: Translator, a: Number, low: Number, high: Number) -> Number:
    ends = (low, high)
    limits = tuple(_float(n.real) for n in ends if _constant(n.real) and any_of(n.infinite, n.bad) is False)
    if len(limits) < 2 or limits[0] > limits[1]:
        return _least(t, _greatest(t, a, low), high)
    found = t.real()
    more = any_of(all_of(no(a.infinite), found >= a.real), a.under, found >= high.real)
    less = any_of(all_of(no(a.infinite), found <= a.real), a.over, found <= low.real)
    t.require(_Clip(all_of(found >= low.real, found <= high.real, more, less), False, "", found, a, limits))
    return Number(found, bad=a.bad)


def _least(t: Translator, *groups: Any) -> Number:
    """Minimum: at most each number, and at least one of them."""
    numbers = _flat(*groups)
    if len(numbers) == 1:
        (only,) = numbers
        return Number(only.real, only.over, only.under, only.bad)
    least = t.real()
    over, under = all_of(*(n.over for n in numbers)), any_of(*(n.under for n in numbers))
    for n in numbers:
        t.require(any_of(n.over, under, least <= n.real))
    t.require(any_of(over, under, *(all_of(no(n.over), least >= n.real) for n in numbers)))
    return Number(least, over, under, _bad(*numbers))


def _greatest(t: Translator, *groups: Any) -> Number:
    return _negative(_least(t, *map(_negative, _flat(*groups))))


def _signs(t: Translator, a: Number) -> tuple[Term, Term]:
    """Whether a number is positive, and whether it is negative."""
    if _constant(a.real) and a.infinite is False:
        return _float(a.real) > 0.0, _float(a.real) < 0.0
    zero = t.number(0.0)
    return _below(zero, a, "<").true, _below(a, zero, "<").true


def _times(t: Translator, a: Number, b: Number) -> Number:
    if a.infinite is False and b.infinite is False:
        return Number(_product(a.real, b.real), bad=_bad(a, b))
    (a_up, a_down), (b_up, b_down) = _signs(t, a), _signs(t, b)
    infinite = any_of(a.infinite, b.infinite)
    over = all_of(infinite, any_of(all_of(a_up, b_up), all_of(a_down, b_down)))
    under = all_of(infinite, any_of(all_of(a_up, b_down), all_of(a_down, b_up)))
    bad = any_of(_bad(a, b), all_of(infinite, no(any_of(over, under))))
    return Number(_product(a.real, b.real), over, under, bad)


def _product(a: Term, b: Term) -> Term:
    """Product; of a term with few constant values, such as `side(a)`, by cases, so that it is linear."""
    if _constant(a) or _constant(b):
        return a * b
    for switch, other in ((a, b), (b, a)):
        if _switched(switch):
            if z3.is_add(switch):
                return z3.Sum([_product(part, other) for part in switch.children()])
            test, then, otherwise = switch.children()
            return z3.If(test, _product(then, other), _product(otherwise, other))
    return a * b


def _switched(term: Term) -> bool:
    """Whether a term can have only few constant values."""
    if _constant(term):
        return True
    if z3.is_app_of(term, z3.Z3_OP_ITE):
        return all(_switched(part) for part in term.children()[1:])
    return bool(z3.is_add(term)) and all(_switched(part) for part in term.children())


def _over(t: Translator, a: Number, b: Number) -> Number:
    up, down = _signs(t, b)
    over, under = any_of(all_of(a.over, up), all_of(a.under, down)), any_of(all_of(a.over, down), all_of(a.under, up))
    bad = any_of(_bad(a, b), no(any_of(up, down)), all_of(a.infinite, b.infinite))
    return Number(choice(b.infinite, t.number(0.0).real, a.real / b.real), over, under, bad)


def _if(t: Translator, test: Truth, a: Any, b: Any) -> Any:
    if isinstance(a, Truth):
        true = any_of(all_of(test.true, a.true), all_of(test.false, b.true))
        return Truth(true, all_of(test.valid, choice(test.true, a.valid, b.valid)))
    bad = any_of(no(test.valid), choice(test.true, a.bad, b.bad))
    over, under = choice(test.true, a.over, b.over), choice(test.true, a.under, b.under)
    return Number(choice(test.true, a.real, b.real), over, under, bad)


def _sign(t: Translator, a: Number) -> Number:
    up, down = _signs(t, a)
    zero, one = t.number(0.0).real, t.number(1.0).real
    return Number(choice(up, one, choice(down, -one, zero)), bad=a.bad)


def _side(t: Translator, a: Number) -> Number:
    _, down = _signs(t, a)
    return Number(choice(down, t.number(-1.0).real, t.number(1.0).real), bad=a.bad)


def _count(t: Translator, group: Any) -> Number:
    truths = _flat(group)
    one, zero = t.number(1.0).real, t.number(0.0).real
    invalid = any_of(*(no(each.valid) for each in truths))
    return Number(z3.Sum([choice(each.true, one, zero) for each in truths]), bad=invalid)


def _first_least(t: Translator, group: Any) -> Number:
    numbers = _flat(group)
    least, index = _least(t, numbers), t.number(len(numbers) - 1.0).real
    for i in reversed(range(len(numbers) - 1)):
        index = choice(_below(numbers[i], least, "<=").true, t.number(float(i)).real, index)
    return Number(index, bad=least.bad)


def _least_valid(t: Translator, group: Any, least: Number) -> Number:
    numbers = _flat(group)
    found = _least(t, numbers)
    return found if found.bad is False else Number(t.real(), t.flag(), t.flag(), t.flag())


def _root(t: Translator, a: Number) -> Number:
    root, (_, negative) = t.real(), _signs(t, a)
    t.require(any_of(a.infinite, a.real < 0, all_of(root >= 0, root * root == a.real)))
    return Number(root, a.over, False, any_of(a.bad, negative))


def _hypot(t: Translator, a: Number, b: Number) -> Number:
    length = t.real()
    t.require(all_of(length >= 0, length * length == a.real * a.real + b.real * b.real))
    sizes = [z3.If(n.real < 0, -n.real, n.real) for n in (a, b)]
    t.require(all_of(*(length >= size for size in sizes), length <= z3.Sum(sizes)))
    return Number(length, any_of(a.infinite, b.infinite), False, _bad(a, b))


def _wrapped(t: Translator, a: Number) -> Number:
    turns, angle, half = z3.ToReal(z3.Int(f"{t.real()}", t.context)), t.real(), t.number(math.pi).real
    t.require(all_of(angle == a.real - 2 * half * turns, angle >= -half, angle <= half))
    return Number(angle, bad=any_of(a.bad, a.infinite))


def _abs(t: Translator, a: Number) -> Number:
    return _greatest(t, a, _negative(a))


_ROWS: Mapping[str, Callable[..., Any]] = {
    "not": lambda t, a: negated(a),
    "and": lambda t, *truths: every(*truths),
    "or": lambda t, *truths: some(*truths),
    "any": lambda t, group: some(*_flat(group)),
    "all": lambda t, group: every(*_flat(group)),
    "if": _if,
    "neg": lambda t, a: _negative(a),
    "+": _total,
    "-": lambda t, a, b: _total(t, a, _negative(b)),
    "*": _times,
    "/": _over,
    "sum": _total,
    "mean": _mean,
    "dot": lambda t, group, vector: _total(t, *(_times(t, a, b) for a, b in zip(_flat(group), vector, strict=True))),
    "count": _count,
    "min": _least,
    "max": _greatest,
    "min_valid": _least_valid,
    "argmin": _first_least,
    "abs": _abs,
    "clip": _clip,
    "sign": _sign,
    "side": _side,
    "sqrt": _root,
    "hypot": _hypot,
    "wrap_angle": _wrapped,
}


def _angle(t: Translator, text: str, y: Number, x: Number) -> Number:
    angle, half = t.real(), t.number(math.pi).real
    t.require(all_of(angle >= -half, angle <= half), unknown=text)
    return Number(angle, bad=_bad(x, y))


def _literal(t: Translator, text: str, steady: Truth) -> Term:
    """Unknown truth value, equal to another one if all signals are steady."""
    found = t.flag()
    t.require(found == steady.true, steady=True, unknown=text)
    return found


def _held(t: Translator, text: str, a: Truth) -> Truth:
    held = _literal(t, text, a)
    return Truth(all_of(held, a.true), any_of(a.true, no(held)))


def _once(t: Translator, text: str, a: Truth) -> Truth:
    once = _literal(t, text, a)
    return Truth(once, any_of(once, a.false))


def _since(t: Translator, text: str, a: Truth, b: Truth) -> Truth:
    since = _literal(t, text, b)
    true = all_of(since, any_of(a.true, b.true))
    return Truth(true, any_of(true, all_of(no(since), b.false)))


def _time_since(t: Translator, text: str, a: Truth) -> Number:
    time, never = t.real(), t.flag()
    t.require(time >= 0, unknown=text)
    t.require(choice(a.true, all_of(time == 0, no(never)), never), steady=True)
    return Number(time, never)


def _rate(t: Translator, text: str, a: Number) -> Number:
    rate = Number(t.real(), t.flag(), t.flag())
    t.require(no(all_of(rate.over, rate.under)), unknown=text)
    t.require(all_of(rate.real == 0, no(rate.infinite)), steady=True)
    return rate


def _delay(t: Translator, text: str, a: Any) -> Any:
    if isinstance(a, Truth):
        found = _literal(t, text, a)
        return Truth(found)
    past = Number(t.real(), t.flag(), t.flag())
    t.require(no(all_of(past.over, past.under)), unknown=text)
    same = all_of(past.over == a.over, past.under == a.under, any_of(a.infinite, past.real == a.real))
    t.require(same, steady=True)
    return past


_NAMED: Mapping[str, Callable[..., Any]] = {
    "atan2": _angle,
    "held": _held,
    "once": _once,
    "since": _since,
    "time_since": _time_since,
    "rate": _rate,
    "delay": _delay,
}
"""Operators of which only a part of the meaning is known; they take the source text too."""
