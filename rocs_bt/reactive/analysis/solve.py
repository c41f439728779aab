"""Solver for formulas: propagates bounds, then branches on disjunctions, with conflict-directed backjumping.

A decision is the choice of one alternative of a disjunction. Every bound and inequality carries the bit set of the
decisions from which it follows. If an alternative fails for reasons that do not include its own decision, the other
alternatives would fail for the same reasons and are not tried (P. Prosser, "Hybrid algorithms for the constraint
satisfaction problem", Computational Intelligence 9(3), 1993).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import reduce
from operator import or_

from .formula import Bound, Effort, Formula, Join, Row, Undecided
from .interval import Range
from .simplex import Span, solution

DEPTH = 300  # maximum number of nested decisions
GAIN, HUGE = 8, 10**6  # a derived bound must cut 1/8 of the interval and be below HUGE, so that propagation terminates


@dataclass(frozen=True)
class Solution:
    """Values of variables that satisfy a formula."""

    spans: Mapping[int, Span]  # of the variables that the formula restricts
    values: Mapping[int, Fraction | float]  # of the variables that occur in an inequality together with others

    def value(self, var: int) -> float | None:
        """Value of a variable; None if the formula does not restrict it."""
        if var in self.values:
            return float(self.values[var])
        return float(self.spans[var].pick()) if var in self.spans else None


class _End:
    """Minimum (sign -1) or maximum (sign 1) of the sum in an inequality, over the intervals of its variables.

    Attributes:
        value: Extreme of the sum; infinite if a term is, NaN if infinite terms of opposite signs may occur.
        finite: Sum of the finite terms and the constant.
        unbounded: Variables with a term that is unbounded in the direction of `sign`.
        open: Number of terms with an interval that excludes the end that is used.
        why: Bit set of the decisions from which this extreme follows.
    """

    def __init__(self, row: Row, sign: int, span_of: Callable[[int], Span]) -> None:
        self.finite = row.constant
        self.unbounded: list[int] = []
        self.open = self.why = 0
        attained = fixed = False
        for var, factor in row.terms.items():
            span = span_of(var)
            at_low = (factor > 0) is (sign < 0)
            end, left_out = (span.low, span.above) if at_low else (span.high, span.under)
            self.why |= span.low_why if at_low else span.high_why
            self.open += left_out
            if not isinstance(end, float):
                self.finite += factor * end
            elif ((end > 0) is (factor > 0)) is (sign > 0):
                self.unbounded.append(var)
                attained |= not left_out
            else:  # infinite in the opposite direction: the variable can have only this infinite value
                fixed = True
        self.value: Fraction | float = self.finite
        if fixed:
            self.value = math.nan if attained else -sign * math.inf
        elif self.unbounded:
            self.value = sign * math.inf


_Part = tuple[Formula, int]  # a formula that must hold, and the bit set of decisions from which it follows


class _State:
    """State of one branch of the search.

    Attributes:
        spans: Intervals that are narrower than the range of their variable, by variable.
        open: Inequalities and disjunctions that are still undecided, with their decisions.
        changed: Bit set of the variables with an interval that has changed since `open` was last evaluated.
    """

    def __init__(self, spans: dict[int, Span], open_parts: list[_Part]) -> None:
        self.spans, self.open, self.changed = spans, open_parts, 0


class Solver:
    """Search for values of variables that satisfy a formula."""

    def __init__(self, ranges: Callable[[int], Range], effort: Effort) -> None:
        self._ranges = ranges
        self._effort = effort
        self._whole: dict[int, Span] = {}

    def solve(self, formula: Formula) -> Solution | None:
        """Find a solution of a formula; None if it is proved that there is none.

        Raises:
            Undecided: The step budget or the depth of decisions is exhausted.
        """
        found = self._search(_State({}, []), [(formula, 0)], 0)
        return found if isinstance(found, Solution) else None

    def _search(self, state: _State, todo: list[_Part], level: int) -> Solution | int:
        """Assert formulas, then branch until all are decided: a solution, or the decisions that exclude one."""
        failed = self._settle(state, todo)
        if failed is not None:
            return failed
        choices = [(part, why) for part, why in state.open if isinstance(part, Join)]
        if not choices:
            return self._values(state, level)
        if not level & (level - 1) and (failed := self._excluded(state)) is not None:  # rarely: it is slow
            return failed
        choice, why = min(choices, key=lambda each: len(each[0].parts))
        left = [each for each in state.open if each[0] is not choice]
        return self._branch(_State(state.spans, left), choice.parts, why, level)

    def _branch(self, state: _State, parts: Sequence[Formula], why: int, level: int) -> Solution | int:
        """Try the alternatives of a disjunction in turn: a solution, or the decisions that exclude one."""
        if level > DEPTH:
            raise Undecided(f"it takes more than {DEPTH} decisions")
        made = 1 << level
        for part in parts:
            self._effort.spend(5)
            found = self._search(_State(dict(state.spans), list(state.open)), [(part, made)], level + 1)
            if isinstance(found, Solution) or not found & made:
                return found
            why |= found & ~made
        return why

    def _values(self, state: _State, level: int) -> Solution | int:
        """Find values that satisfy the inequalities, once all disjunctions are decided.

        Finite values are tried first. Between two equal infinite values `<=` is true, so an inequality without a finite
        solution may have an infinite one. Then the search branches on whether one of its variables is infinite.
        """
        rows, spans = self._rows(state)
        apart = [row for row in rows if any(_infinite(spans[var]) for var in row.terms)]
        if not apart:
            values, failed = solution(rows, spans, self._effort)
            if values is not None:
                return Solution(state.spans, values)
            apart = [row for row in rows if not row.strict and _meeting(row, spans)]
            if apart:
                values, failed = solution([row for row in rows if row not in apart], spans, self._effort)
            if values is None:
                return failed
        var = next(var for row in apart for var in _meeting(row, spans) if not _infinite(spans[var]))
        greatest = spans[var].high == math.inf and not spans[var].under
        end = math.inf if greatest else -math.inf
        return self._branch(state, (Bound(var, not greatest, end, False), Bound(var, greatest, end, True)), 0, level)

    def _excluded(self, state: _State) -> int | None:
        """Bit set of the decisions that make the undecided inequalities infeasible; None if they are feasible.

        If they are infeasible, no alternative of an undecided disjunction can help.
        """
        rows, spans = self._rows(state)
        rows = [row for row in rows if not any(_infinite(spans[v]) for v in row.terms)]
        rows = [row for row in rows if row.strict or not _meeting(row, spans)]
        values, failed = solution(rows, spans, self._effort)
        return failed if values is None else None

    def _rows(self, state: _State) -> tuple[list[Row], dict[int, Span]]:
        """Undecided inequalities, each with the decisions from which it follows, and the intervals of their variables.

        Between two equal infinite values `<=` is true. Where bounds exclude this case, the decisions behind these
        bounds are added to those of the inequality.
        """
        rows: list[Row] = []
        spans: dict[int, Span] = {}
        for row, why in state.open:
            if isinstance(row, Row):
                own = {var: self._span(state, var) for var in row.terms}
                if not row.strict and _meeting(row, {var: self._range(var) for var in own}):
                    why = reduce(or_, (span.low_why | span.high_why for span in own.values()), why)
                rows.append(replace(row, why=why))
                spans |= own
        return rows, spans

    def _settle(self, state: _State, todo: list[_Part]) -> int | None:
        """Assert formulas and propagate bounds until nothing changes.

        Returns:
            None, or the bit set of the decisions that are in conflict.
        """
        while True:
            while todo:
                if (failed := self._take(state, *todo.pop(), todo)) is not None:
                    return failed
            if not state.changed:
                return None
            touched, state.changed = state.changed, 0
            parts, state.open = state.open, []
            for part, why in parts:
                if not part.vars & touched:
                    state.open.append((part, why))
                elif (failed := self._take(state, part, why, todo)) is not None:
                    return failed

    def _take(self, state: _State, part: Formula, why: int, todo: list[_Part]) -> int | None:
        """Assert a formula and append its consequences to `todo`.

        Returns:
            None, or the bit set of the decisions that are in conflict.
        """
        self._effort.spend()
        if isinstance(part, Row):
            return self._contract(state, part, why, todo)
        if isinstance(part, Join):
            if not part.every:
                return self._reduce(state, part, why, todo)
            todo += [(each, why) for each in part.parts]
            return None
        span = self._span(state, part.var)
        cut = span.cut(part.value, part.upper, part.strict, why)
        if cut.empty:
            return cut.low_why | cut.high_why
        if cut is not span:
            state.spans[part.var] = cut
            state.changed |= part.vars
        return None

    def _reduce(self, state: _State, choice: Join, why: int, todo: list[_Part]) -> int | None:
        """Remove the alternatives of a disjunction that cannot hold; arguments and result as in `_take`.

        A single remaining alternative is asserted. A disjunction that always holds is dropped.
        """
        left = []
        for part in choice.parts:
            holds, reason = self._judge(state, part)
            if holds:
                return None
            if holds is None:
                left.append(part)
            else:
                why |= reason
        if not left:
            return why
        if len(left) == 1:
            todo.append((left[0], why))
            return None
        choice = choice if len(left) == len(choice.parts) else Join(False, tuple(left), choice.defines)
        state.open.append((choice, why))
        for upper in (True, False) if choice.defines >= 0 else ():
            found = self._implied(state, choice, choice.defines, upper)
            if found is not None and _worthwhile(self._span(state, choice.defines), found[0]):
                todo.append((found[0], why | found[1]))
        return None

    def _implied(self, state: _State, part: Formula, var: int, upper: bool) -> tuple[Bound, int] | None:
        """Bound of a variable that a formula implies, and the decisions from which it follows; None without a bound."""
        if isinstance(part, Bound):
            return (part, 0) if part.var == var and part.upper is upper else None
        if isinstance(part, Row):
            if var not in part.terms or (part.terms[var] > 0) is not upper:
                return None
            low = self._end(state, part, -1)
            bound = self._rest(state, part, var, low)
            return None if bound is None else (bound, low.why)
        found = [self._implied(state, each, var, upper) for each in part.parts]
        known = [each for each in found if each is not None]
        if not known or (len(known) < len(found) and not part.every):
            return None
        pick = min if upper is part.every else max
        bound, reason = pick(known, key=lambda each: (each[0].value, each[0].strict is not upper))
        return bound, reason if part.every else reduce(or_, (each[1] for each in known))

    def _judge(self, state: _State, part: Formula) -> tuple[bool | None, int]:
        """Whether a formula always holds (True), never holds (False), or is undecided (None) within the intervals.

        Returns the verdict, and the bit set of the decisions that exclude the formula.
        """
        self._effort.spend()
        if isinstance(part, Bound):
            span = self._span(state, part.var)
            if span.cut(part.value, part.upper, part.strict).empty:
                return False, span.low_why if part.upper else span.high_why
            return (True if span.cut(part.value, not part.upper, not part.strict).empty else None), 0
        if isinstance(part, Row):
            low = self._end(state, part, -1)
            return self._row_holds(state, part, low), low.why
        verdicts, why = [], 0
        for each in part.parts:
            holds, reason = self._judge(state, each)
            if holds is not None and holds is not part.every:
                return holds, reason
            verdicts.append(holds)
            why |= reason
        return (None if None in verdicts else part.every), why

    def _contract(self, state: _State, row: Row, why: int, todo: list[_Part]) -> int | None:
        """Derive a bound of each variable of an inequality from the other ones; arguments and result as in `_take`.

        An inequality that always holds is dropped.
        """
        low = self._end(state, row, -1)
        holds = self._row_holds(state, row, low)
        if holds is not None:
            return None if holds else why | low.why
        state.open.append((row, why))
        for var in low.unbounded or row.terms:
            bound = self._rest(state, row, var, low)
            if bound is not None and _worthwhile(self._span(state, var), bound):
                todo.append((bound, why | low.why))
        return None

    def _rest(self, state: _State, row: Row, var: int, low: _End) -> Bound | None:
        """Bound of a variable that follows from an inequality with all other terms at their minimum.

        Returns:
            The bound, or None if another term has no minimum.
        """
        factor = row.terms[var]
        if low.unbounded not in ([], [var]):
            return None
        if math.isnan(low.value):  # another variable is infinite, so this variable must be infinite, too
            return Bound(var, factor > 0, -math.inf if factor > 0 else math.inf, row.strict)
        span = self._span(state, var)
        end, left_out = (span.low, span.above) if factor > 0 else (span.high, span.under)
        rest = low.finite if isinstance(end, float) else low.finite - factor * end
        return Bound(var, factor > 0, -rest / factor, row.strict or low.open > left_out)

    def _row_holds(self, state: _State, row: Row, low: _End) -> bool | None:
        """Whether an inequality always holds (True), never holds (False), or is undecided (None)."""
        if low.value > 0 or (low.value == 0 and (low.open or row.strict)) or (math.isnan(low.value) and row.strict):
            return False
        high = self._end(state, row, 1)
        if high.value < 0 or (high.value == 0 and (high.open or not row.strict)):
            return True
        return True if math.isnan(high.value) and not row.strict else None

    def _end(self, state: _State, row: Row, sign: int) -> _End:
        self._effort.spend(1 + len(row.terms) // 8)
        return _End(row, sign, lambda var: self._span(state, var))

    def _span(self, state: _State, var: int) -> Span:
        span = state.spans.get(var)
        return self._range(var) if span is None else span

    def _range(self, var: int) -> Span:
        if var not in self._whole:
            self._whole[var] = Span.of(*self._ranges(var))
        return self._whole[var]


def _worthwhile(span: Span, bound: Bound) -> bool:
    """Whether a bound narrows an interval enough to be applied. Without this limit propagation might not terminate."""
    cut = span.cut(bound.value, bound.upper, bound.strict)
    if cut is span:
        return False
    end = span.high if bound.upper else span.low
    if cut.empty or end == bound.value or isinstance(end, float) or isinstance(bound.value, float):
        return True
    half = isinstance(span.low, float) or isinstance(span.high, float)
    width = max(Fraction(1), abs(end)) if half else abs(Fraction(span.high) - Fraction(span.low))
    return abs(end - bound.value) * GAIN > width and abs(bound.value) < HUGE


def _infinite(span: Span) -> bool:
    """Whether the interval is a single infinite value."""
    return isinstance(span.low, float) and span.low == span.high


def _meeting(row: Row, spans: Mapping[int, Span]) -> list[int]:
    """Variables of an inequality with terms that can be infinite with opposite signs; empty if no two terms can."""
    ends: dict[int, list[int]] = {1: [], -1: []}
    for var, factor in row.terms.items():
        span, sign = spans[var], 1 if factor > 0 else -1
        if span.high == math.inf and not span.under:
            ends[sign].append(var)
        if span.low == -math.inf and not span.above:
            ends[-sign].append(var)
    return [*ends[1], *ends[-1]] if ends[1] and ends[-1] else []
