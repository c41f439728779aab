"""Looks for a solution of a formula: boxes first, linear inequalities where signals are compared with each other.

The search takes every `or` apart only when the boxes leave it more than one part.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from .eliminate import Span, solution
from .formula import Bound, Effort, Formula, Join, Literal, Row, Undecided
from .interval import Range


@dataclass(frozen=True)
class Solution:
    """Values with which a formula holds.

    Attributes:
        spans: What each variable that matters can be.
        values: The values of variables that are compared with each other.
    """

    spans: Mapping[int, Span]
    values: Mapping[int, Fraction | float]

    def value(self, var: int) -> float | None:
        """A value of a variable; None where any will do."""
        if var in self.values:
            return float(self.values[var])
        return float(self.spans[var].pick()) if var in self.spans else None


class Solver:
    """One search.

    Args:
        ranges: What a variable can be.
        effort: What it may take.
    """

    def __init__(self, ranges: Callable[[int], Range], effort: Effort) -> None:
        self._ranges = ranges
        self._effort = effort
        self._doubt = ""

    def solve(self, formula: Formula) -> Solution | None:
        """A solution; None where there surely is none.

        Raises:
            Undecided: It takes too many steps, or infinite numbers decide.
        """
        found = self._search(_State({}, {}, (), ()), [formula])
        if found is None and self._doubt:
            raise Undecided(self._doubt)
        return found

    def _search(self, state: _State, todo: list[Formula]) -> Solution | None:
        self._effort.spend(10)
        state = state.copy()
        if not self._settle(state, todo):
            return None
        values: dict[int, Fraction | float] | None = {}
        if state.rows:
            values = self._linear(state)
            if values is None:
                return None
        if not state.choices:
            return Solution(state.spans, values or {})
        choice, rest = state.choices[0], state.choices[1:]
        for part in choice.parts:
            found = self._search(_State(state.spans, state.truths, state.rows, ()), [part, *rest])
            if found is not None:
                return found
        return None

    def _settle(self, state: _State, todo: list[Formula]) -> bool:
        """Take over all that is certain; whether anything is left."""
        while True:
            while todo:
                part = todo.pop()
                if isinstance(part, Join) and part.every:
                    todo += part.parts
                elif isinstance(part, Join):
                    state.choices = (part, *state.choices)
                elif not self._take(state, part):
                    return False
            left: list[Join] = []
            for choice in state.choices:
                parts = [(part, self._holds(state, part)) for part in choice.parts]
                if any(holds is True for _, holds in parts):
                    continue
                open_parts = tuple(part for part, holds in parts if holds is None)
                if len(open_parts) > 1:
                    left.append(Join(False, open_parts))
                elif open_parts:
                    todo.append(open_parts[0])
                else:
                    return False
            state.choices = tuple(left)
            if not todo:
                return True

    def _take(self, state: _State, part: Formula) -> bool:
        match part:
            case Bound():
                span = self._span(state, part.var).cut(part.value, part.upper, part.strict)
                state.spans[part.var] = span
                return not span.empty
            case Literal():
                return state.truths.setdefault(part.var, part.value) is part.value
            case Row():
                holds = self._holds(state, part)
                if holds is None:
                    state.rows = (*state.rows, part)
                return holds is not False
        return True

    def _span(self, state: _State, var: int) -> Span:
        if var not in state.spans:
            return Span(*self._ranges(var))
        return state.spans[var]

    def _holds(self, state: _State, part: Formula) -> bool | None:
        """Whether a part is true, or false, whatever the boxes leave; None where they leave both."""
        self._effort.spend()
        match part:
            case Bound():
                span = self._span(state, part.var)
                if span.cut(part.value, part.upper, part.strict).empty:
                    return False
                return None if not span.cut(part.value, not part.upper, not part.strict).empty else True
            case Literal():
                known = state.truths.get(part.var)
                return None if known is None else known is part.value
            case Row():
                return self._row_holds(state, part)
        held = [self._holds(state, each) for each in part.parts]
        if part.every:
            return False if False in held else None if None in held else True
        return True if True in held else None if None in held else False

    def _row_holds(self, state: _State, row: Row) -> bool | None:
        low: Fraction | float = row.constant
        high: Fraction | float = row.constant
        for var, factor in row.terms.items():
            span = self._span(state, var)
            ends = _scaled(span.low, factor), _scaled(span.high, factor)
            low, high = _added(low, min(ends)), _added(high, max(ends))
        if high < 0 or (high == 0 and not row.strict):
            return True
        if math.isnan(low) or low < 0 or (low == 0 and not row.strict):
            return None
        return False

    def _linear(self, state: _State) -> dict[int, Fraction | float] | None:
        """Values with which the rows hold; None where there are none.

        A variable that only infinity is left of is no matter of inequalities. Where two infinite values can meet,
        `<=` may hold without any finite values for it, so such rows are left out before it is said that none are.
        """
        spans = {var: self._span(state, var) for row in state.rows for var in row.terms}
        if any(span.low == span.high and math.isinf(span.low) for span in spans.values()):
            self._doubt = "a signal that must be infinite is compared with others"
            return None
        found = solution(state.rows, spans, self._effort)
        if found is None:
            plain = [row for row in state.rows if row.strict or not _can_meet(row, spans)]
            if len(plain) < len(state.rows) and solution(plain, spans, self._effort) is not None:
                self._doubt = "infinite values of several signals would decide it"
        return found


class _State:
    """What a branch of the search has settled."""

    def __init__(
        self,
        spans: dict[int, Span],
        truths: dict[int, bool],
        rows: tuple[Row, ...],
        choices: tuple[Join, ...],
    ) -> None:
        self.spans, self.truths, self.rows, self.choices = spans, truths, rows, choices

    def copy(self) -> _State:
        return _State(dict(self.spans), dict(self.truths), self.rows, self.choices)


def _scaled(value: Fraction | float, factor: Fraction) -> Fraction | float:
    return value * (1 if factor > 0 else -1) if math.isinf(value) else Fraction(value) * factor


def _added(a: Fraction | float, b: Fraction | float) -> Fraction | float:
    return a + b if not (math.isinf(a) or math.isinf(b)) else float(a) + float(b)


def _can_meet(row: Row, spans: Mapping[int, Span]) -> bool:
    ends = set()
    for var, factor in row.terms.items():
        ends |= {end * (1 if factor > 0 else -1) for end in (spans[var].low, spans[var].high) if math.isinf(end)}
    return len(ends) > 1
