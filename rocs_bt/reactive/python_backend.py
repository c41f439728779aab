"""Back end that generates one Python function for all rules, for machines on which the kernel is not compiled.

`rocs-bt show RULES --compiled` prints the function.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..expression.program import TOLERANCE
from ..expression.python_code import PythonCode, define, sum_code
from .backend import Floats, Machine, SequentialBatch
from .rule_table import COLUMNS, RuleTable

_CLEAR, _TRIP, _HOLD = 0, 1, 2


class PythonBackend(SequentialBatch):
    """Back end that runs tables as generated Python code; always available."""

    name = "python"

    def machine(self, table: RuleTable) -> Machine:
        return PythonMachine(table)


class PythonMachine:
    """Rules of one robot as generated Python code; see Machine.

    The state is stored in lists, because generated code reads and writes them faster than arrays.
    """

    def __init__(self, table: RuleTable) -> None:
        self.table = table
        count = len(table.names)
        self.mask: list[bool] = [False] * count
        self.blind: list[bool] = [False] * count
        self.margins: list[float] = []
        self._busy = [False] * count  # whether a rule must be advanced even if its guard is false
        self._risen = [math.inf] * count
        self._ready = [-math.inf] * count
        self._unknown = [math.inf] * count
        self._enabled = [True] * count
        self._cells: list[float] = []
        self._registers: dict[int, Any] = {}
        self._latched: dict[int, int] = {}  # priorities of the latched rules
        self._time = -math.inf
        self._columns: dict[str, list[Any]] = {
            "latched": self.mask, "risen": self._risen, "ready": self._ready, "unknown": self._unknown,
            "enabled": self._enabled, "blind": self.blind,
        }  # fmt: skip  # a table
        self._hold, self._cooldown = table.hold.tolist(), table.cooldown.tolist()
        self._max_hold, self._level = table.max_hold.tolist(), table.level.tolist()
        self._on_invalid, self._priority = table.on_invalid.tolist(), table.priority.tolist()
        self._has_until = (table.until >= 0).tolist()
        names = {"advance": self._advance, "busy": self._busy, "latched": self.mask, "registers": self._registers}
        self._run: Callable[[Sequence[float], float, list[float]], list[float]]
        self._run = define(python_source(table), "step", names)
        self.restore(table.initial)

    def step(self, x: Floats, t: float) -> int:
        """Advance all rules; see Machine."""
        if t < self._time:
            self._begin(self.table.initial)
        self._time = t
        self.margins = self._run(x.tolist(), t, self._cells)
        if not self._latched:
            return -1
        return min(self._latched, key=lambda rule: (-self._latched[rule], rule))

    def register(self, index: int) -> float:
        """Value of a register of the program, NaN if invalid; only results of temporal operators are available."""
        value = self._registers.get(index, math.nan)
        return math.nan if value is None else float(value)

    def values(self) -> Floats:
        """Copy of the state; see Machine."""
        columns = [self._columns[name] for name in COLUMNS]
        return np.array([self._time, *self._cells, *(v for column in columns for v in column), *self.margins], float)

    def restore(self, values: Floats) -> None:
        """Replace the state; see Machine."""
        self._enabled[:] = map(bool, values[self.table.part("enabled")].tolist())
        self._begin(values)
        self._time = float(values[0])

    def enable(self, rule: int, on: bool) -> None:
        """Enable or disable a rule; see Machine."""
        self._enabled[rule] = on
        self._busy[rule] = True

    def _begin(self, values: Floats) -> None:
        """Set the state from a state array, except `enabled` and the time."""
        part = self.table.part
        for name in COLUMNS:
            if name != "enabled":
                column = values[part(name)].tolist()
                self._columns[name][:] = map(bool, column) if name in ("latched", "blind") else column
        self._cells[:] = values[part("cells")].tolist()
        self.margins = values[part("margin")].tolist()
        self._latched.clear()
        self._latched.update({i: self._priority[i] for i, on in enumerate(self.mask) if on})
        self._busy[:] = [True] * len(self._busy)

    def _advance(self, i: int, guard: bool | None, until: bool | None, t: float) -> None:
        """Advance one rule, as specified in `rule_table`.

        Args:
            i: Index of the rule.
            guard: Value of `when`; None if invalid.
            until: Value of `until`, used only if the rule has one and is latched; None if invalid.
            t: Time of the snapshot [s].
        """
        latched = self.mask[i]
        if not self._enabled[i]:
            self._risen[i] = self._unknown[i] = math.inf
            self.blind[i] = self._busy[i] = False
            if latched:
                self._release(i, t)
            return
        if not latched:
            decided = guard
        elif self._has_until[i]:
            decided = until
        else:
            decided = None if guard is None else not guard
        self.blind[i] = guard is None or decided is None
        if decided is None:
            decided = self._policy(i, latched, t)
        else:
            self._unknown[i] = math.inf
        if decided is not None:
            if latched:
                if decided:
                    self._release(i, t)
            elif decided:
                self._rise(i, t)
            else:
                self._risen[i] = math.inf
        self._busy[i] = self.mask[i] or self.blind[i] or self._risen[i] != math.inf or self._unknown[i] != math.inf

    def _policy(self, i: int, latched: bool, t: float) -> bool | None:
        """Decide for a rule with an invalid guard or release condition, by its `on_invalid`.

        Returns:
            Whether the rule latches, or, if it is latched, whether it is released. None if it keeps its state.
        """
        if self._unknown[i] == math.inf:
            self._unknown[i] = t
        meaning = self._on_invalid[i]
        if meaning == _HOLD and t - self._unknown[i] < self._max_hold[i]:
            return None
        return (meaning != _CLEAR) is not latched

    def _rise(self, i: int, t: float) -> None:
        if self._risen[i] == math.inf:
            self._risen[i] = t
        if t - self._risen[i] >= self._hold[i] and t >= self._ready[i] - TOLERANCE:
            self.mask[i], self._risen[i] = True, math.inf
            self._latched[i] = self._priority[i]
            if not self._level[i]:
                self._ready[i] = t + self._cooldown[i]

    def _release(self, i: int, t: float) -> None:
        self.mask[i] = False
        del self._latched[i]
        if self._level[i]:
            self._ready[i] = t + self._cooldown[i]


def python_source(table: RuleTable) -> str:
    """Generate the Python source of a table.

    The source has two functions: `step(x, t, cells)` is fast and calls `careful(x, t, cells)` for a snapshot with NaN.
    Both call `advance(rule, guard, until, t)` for each rule that is in `busy` or has a guard that is not false.
    """
    program = table.program
    lines = ["def step(x, t, cells):"]
    if program.reads:
        lines += [
            f"    s = {sum_code(program)}",
            "    if s != s:  # an input is invalid",
            "        return careful(x, t, cells)",
        ]
    return "\n".join(
        [*lines, *_body(table, fast=True), "", "", "def careful(x, t, cells):", *_body(table, fast=False), ""]
    )


def _body(table: RuleTable, fast: bool) -> list[str]:
    when, until, margins = table.when.tolist(), table.until.tolist(), table.margins.tolist()
    code = PythonCode(table.program, [*when, *(r for r in until if r >= 0), *margins], fast)
    lines = list(code.lines)
    lines += [f"registers[{register}] = v{register}" for register in dict.fromkeys(table.program.temporal.values())]
    for i, name in enumerate(table.names):
        guard = code.value(when[i])
        release = f"{code.value(until[i])} if latched[{i}] else None" if until[i] >= 0 else "None"
        lines += [f"# {' '.join(name.split())}", f"g = {guard}"]  # a file name may contain line breaks
        held = "g" if code.sure(when[i]) else "g is not False"
        lines += [f"if {held} or busy[{i}]:", f"    advance({i}, g, {release}, t)"]
    lines.append(f"return [{', '.join(code.value(register) for register in margins)}]")
    return [f"    {line}" for line in lines]
