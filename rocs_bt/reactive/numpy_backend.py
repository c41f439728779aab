"""Back end in numpy: the reference of the kernel, and its replacement where it is not compiled."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from itertools import pairwise
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..expression.program import TOLERANCE
from ..expression.rows import Rows
from .backend import Floats, Machine, Steps
from .rule import OnInvalid
from .rule_table import COLUMNS, INVALID_CODE, RuleTable

_CLEAR, _HOLD = INVALID_CODE[OnInvalid.CLEAR], INVALID_CODE[OnInvalid.HOLD]
_INF = math.inf


class NumpyBackend:
    """Back end that evaluates the program of a table in numpy, and its rules one after the other."""

    name = "numpy"

    def __init__(self) -> None:
        self._runners: WeakKeyDictionary[RuleTable, _Runner] = WeakKeyDictionary()

    def machine(self, table: RuleTable) -> Machine:
        return NumpyMachine(table, self._runner(table))

    def batch_time(self, table: RuleTable, x: Floats, t: Floats, values: Floats) -> Steps:
        steps, runner, state = Steps.empty(table, len(x)), self._runner(table), values[np.newaxis]
        backward = (np.flatnonzero(np.diff(t) < 0.0) + 1).tolist()
        for a, b in pairwise([0, *backward, len(t)]):
            if a < b:
                runner.begin(state, t[a])
            for part, registers in runner.rows.chunks(x[a:b], t[a:b], state[:, table.part("cells")]):
                at = slice(a + part.start, min(a + part.stop, b))
                steps.mask[at] = runner.advance(registers, t[at].tolist(), values)
                steps.margin[at] = registers[table.margins].T
        steps.winner[:] = runner.winners(steps.mask)
        return steps

    def batch_lanes(self, table: RuleTable, x: Floats, t: float, values: Floats) -> Steps:
        steps, runner = Steps.empty(table, len(x)), self._runner(table)
        runner.begin(values, t)
        registers = runner.rows(x, np.full(len(x), t), values[:, table.part("cells")])
        for lane, state in enumerate(values):
            steps.mask[lane] = runner.advance(registers[:, lane : lane + 1], [t], state)
        steps.winner[:], steps.margin[:] = runner.winners(steps.mask), registers[table.margins].T
        return steps

    def _runner(self, table: RuleTable) -> _Runner:
        """Evaluator of a table, cached."""
        found = self._runners.get(table)
        if found is None:
            found = self._runners[table] = _Runner(table)
        return found


class NumpyMachine(Machine):
    """Rules of one robot in numpy; see Machine."""

    def __init__(self, table: RuleTable, runner: _Runner) -> None:
        super().__init__(table)
        self._runner = runner
        self._registers = table.program.registers[:, np.newaxis]
        self.step = self._step
        self.register = lambda index: float(self._registers[index, 0])

    def _step(self, x: Floats, t: float) -> int:
        state = self._values[np.newaxis]
        self._runner.begin(state, t)
        self._registers = self._runner.rows(x[np.newaxis], np.array([t]), state[:, self.table.part("cells")])
        return int(self._runner.winners(self._runner.advance(self._registers, [t], self._values))[0])


class _Runner:
    """Evaluator of one table."""

    def __init__(self, table: RuleTable) -> None:
        self.rows = Rows(table.program)
        # Weak: the back end's cache of runners must not keep their tables.
        self._initial, self._enabled = table.initial, table.part("enabled")
        self._when, self._until, self._margins = table.when, table.until, table.margins
        self._columns = slice(table.part(COLUMNS[0]).start, table.part(COLUMNS[-1]).stop)
        self._margin = table.part("margin")
        self._by_rank = np.lexsort((np.arange(len(table.names)), -table.priority)).astype(np.int32)
        columns = (table.hold, table.cooldown, table.max_hold, table.level, table.on_invalid)
        self._rules = [_Life(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]

    def begin(self, states: Floats, t: float) -> None:
        """Reset the states of a later time than t, shape (lanes, width), except `enabled`."""
        late = states[:, 0] > t
        if late.any():
            enabled = states[late, self._enabled]
            states[late] = self._initial
            states[late, self._enabled] = enabled

    def advance(self, registers: Floats, t: Sequence[float], state: Floats) -> NDArray[np.bool_]:
        """Advance all rules of one robot; returns which are latched, shape (n, rules)."""
        guards = registers[self._when]
        columns = state[self._columns].reshape(len(COLUMNS), -1)
        latched, risen, _, unknown, _, blind = columns
        mask = np.zeros((len(t), len(self._rules)), bool)
        awake = (latched != 0.0) | (risen != _INF) | (unknown != _INF) | (blind != 0.0) | (guards != 0.0).any(axis=1)
        for i in np.flatnonzero(awake).tolist():
            life, until = self._rules[i], self._until[i]
            release = registers[until] if until >= 0 else 1.0 - guards[i]
            columns[:, i] = life.run(columns[:, i].tolist(), guards[i], release, t, mask[:, i])
        state[0], state[self._margin] = t[-1], registers[self._margins, -1]
        return mask

    def winners(self, mask: NDArray[np.bool_]) -> NDArray[np.int32]:
        """Latched rule with the highest priority of each row, -1 for none."""
        if not self._by_rank.size:
            return np.full(len(mask), -1, np.int32)
        ranked = mask[:, self._by_rank]
        return np.where(ranked.any(axis=1), self._by_rank[ranked.argmax(axis=1)], np.int32(-1))


class _Life:
    """Steps of one rule, as `rule_table` defines them."""

    def __init__(self, hold: float, cooldown: float, max_hold: float, level: int, on_invalid: int) -> None:
        self._hold, self._cooldown, self._max_hold = hold, cooldown, max_hold
        self._level, self._on_invalid = level, on_invalid

    def run(
        self, state: list[float], guard: Floats, release: Floats, t: Sequence[float], mask: NDArray[np.bool_]
    ) -> list[float]:
        """Advance the rule over n rows; returns its columns.

        In a series, rows are skipped in which the rule stays inactive or latched, since these are nearly all.

        Args:
            state: Columns of the rule.
            guard: Values of `when`.
            release: Values of `until`, or of `not when`.
            t: Times [s].
            mask: Set to whether the rule is latched.
        """
        if len(t) == 1:
            state = self._step(state, float(guard[0]), float(release[0]), t[0])
            mask[0] = state[0] != 0.0
            return state
        rises, releases = (np.flatnonzero(each != 0.0).tolist() for each in (guard, release + 0.0 * guard))
        guards, decided, k = guard.tolist(), release.tolist(), 0
        while k < len(t):
            state = self._step(state, guards[k], decided[k], t[k])
            latched, risen, _, unknown, enabled, blind = state
            mask[k] = latched != 0.0
            k += 1
            if enabled == 0.0:
                break
            if risen == unknown == _INF and blind == 0.0:
                changes = releases if latched else rises
                at = bisect_left(changes, k)
                stop = changes[at] if at < len(changes) else len(t)
                mask[k:stop] = latched != 0.0
                k = stop
        return state

    def _step(self, state: list[float], guard: float, release: float, t: float) -> list[float]:
        latched, risen, ready, unknown, enabled, blind = state
        decided = release if latched else guard
        if not enabled:
            risen, unknown, blind = _INF, _INF, 0.0
            decided = latched
        else:
            blind = float(guard != guard or decided != decided)
            if decided == decided:
                unknown = _INF
            else:
                unknown = t if unknown == _INF else unknown
                if self._on_invalid == _HOLD and t - unknown < self._max_hold:
                    return [latched, risen, ready, unknown, enabled, blind]
                decided = float((self._on_invalid != _CLEAR) != (latched != 0.0))
        if latched:
            if decided:
                latched, ready = 0.0, t + self._cooldown if self._level else ready
        elif not decided:
            risen = _INF
        else:
            risen = t if risen == _INF else risen
            if t - risen >= self._hold and t >= ready - TOLERANCE:
                latched, risen, ready = 1.0, _INF, ready if self._level else t + self._cooldown
        return [latched, risen, ready, unknown, enabled, blind]
