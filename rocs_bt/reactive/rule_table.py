"""Rule table: a rule set compiled to a register program and to columns of numbers for all rules.

All back ends run this table and give bit-identical winners, masks, margins and states.

**State** of one robot: one float64 array `values` of shape (width,); that of N robots has the shape (N, width). With C
cells and R rules it contains, in this order:

==============  ======  ========================================================================================
`time`          1       time of the last step; -inf before the first
`cells`         C       state of the temporal operators, see expression/program.py
`latched`       R       1.0 while the rule is latched; the mask
`risen`         R       time since which the guard of an inactive rule holds; +inf: it does not hold
`ready`         R       end of the cooldown; -inf at first
`unknown`       R       time since which the deciding expression (step 2) is invalid; +inf: it is valid
`enabled`       R       1.0 if the rule is active in the agent's mode; written from outside, never by a step
`blind`         R       result: 1.0 if the guard or the deciding expression was invalid in this step
`margin`        R       result: robustness margin of the guard, NaN if invalid; R = 0 in a table without margins
==============  ======  ========================================================================================

**A step** of (x, t), rule by rule in the order of the table, after the program has run:

0. If t < time, everything except `enabled` is reset to its initial value. time = t.
1. If the rule is not enabled: unknown = +inf, risen = +inf, blind = 0; if it was latched, it is released (5). Done.
2. guard = r[when]. decided = guard if the rule is inactive; else r[until], or NOT guard if until is -1.
   blind = 1 if guard or decided is NaN, else 0.
3. If decided is NaN: unknown = t if it is +inf. If on_invalid is HOLD and t - unknown < max_hold: the rule keeps its
   state (with risen); done. decided = 1 if (on_invalid is not CLEAR) differs from (latched), else 0: TRIP and an
   expired HOLD latch an inactive rule and keep a latched one; CLEAR does neither. If decided is not NaN:
   unknown = +inf.
4. Inactive: decided 0: risen = +inf. Decided 1: risen = t if it is +inf; if t - risen >= hold and t >= ready:
   latched = 1, risen = +inf, and for an edge rule ready = t + cooldown.
5. Latched and decided 1: latched = 0, and for a level rule ready = t + cooldown.
   In `hold` and `max_hold` of the table the tolerance of 1e-9 s is already subtracted; `ready` is compared as
   t >= ready - 1e-9.
6. margin = r[margins[i]] of every rule.

The winner is the latched rule with the highest priority; of several, the first one in the table; -1 if none is latched.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..expression import Program, lower
from ..expression.program import TOLERANCE
from .rule import OnInvalid, Rule

INVALID_CODE = {OnInvalid.CLEAR: 0, OnInvalid.TRIP: 1, OnInvalid.HOLD: 2}
COLUMNS = ("latched", "risen", "ready", "unknown", "enabled", "blind")
_FIRST = {"latched": 0.0, "risen": np.inf, "ready": -np.inf, "unknown": np.inf, "enabled": 1.0, "blind": 0.0}


@dataclass(frozen=True, eq=False)
class RuleTable:
    """Rule set compiled to a register program and to columns of numbers; the module describes state and steps.

    Attributes:
        names: Names of the R rules.
        program: Register program of the guards. `program.temporal` maps each temporal operator to its register, for
            parameters and guard texts.
        when: Registers of the guards, int32, shape (R,).
        until: Registers of the release conditions, int32, shape (R,); -1: release as soon as the guard does not hold.
        margins: Registers of the robustness margins, int32, shape (R,), or (0,) without margins.
        hold: Times for which the guards must hold, minus the tolerance [s], float64, shape (R,).
        cooldown: Cooldowns [s], float64, shape (R,).
        max_hold: Maximum durations of HOLD, minus the tolerance [s], float64, shape (R,).
        level: 1 for level rules, 0 for edge rules, uint8, shape (R,).
        on_invalid: 0 for CLEAR, 1 for TRIP, 2 for HOLD, uint8, shape (R,).
        priority: Priorities, int64, shape (R,).
        initial: Initial state, float64, shape (width,).
    """

    names: tuple[str, ...]
    program: Program
    when: NDArray[np.int32]
    until: NDArray[np.int32]
    margins: NDArray[np.int32]
    hold: NDArray[np.float64]
    cooldown: NDArray[np.float64]
    max_hold: NDArray[np.float64]
    level: NDArray[np.uint8]
    on_invalid: NDArray[np.uint8]
    priority: NDArray[np.int64]
    initial: NDArray[np.float64]

    @property
    def width(self) -> int:
        """Number of values in the state of one robot."""
        return self.initial.size

    def part(self, name: str) -> slice:
        """Slice of the state array for one of its fields: `time`, `cells`, `latched` ... `margin`."""
        cells, rules = self.program.cells.size, len(self.names)
        if name == "time":
            return slice(0, 1)
        if name == "cells":
            return slice(1, 1 + cells)
        if name == "margin":
            return slice(self.width - self.margins.size, self.width)
        start = 1 + cells + COLUMNS.index(name) * rules
        return slice(start, start + rules)

    def listing(self) -> list[str]:
        """Lines for people: the instructions of the program, and the registers of each rule."""
        lines = self.program.listing()
        for name, when, until in zip(self.names, self.when.tolist(), self.until.tolist(), strict=True):
            lines.append(f"{name}: when r{when}" + (f", until r{until}" if until >= 0 else ""))
        return lines

    def start(self, lanes: int | None = None) -> NDArray[np.float64]:
        """Initial state, shape (width,), or (lanes, width) for several robots."""
        return self.initial.copy() if lanes is None else np.tile(self.initial, (lanes, 1))


def lower_rules(rules: Sequence[Rule], margins: bool = False) -> RuleTable:
    """Compile rules to a table.

    Args:
        rules: Rules, in the order of the table.
        margins: Whether every step also computes the robustness margin of each guard.
    """
    guards = [rule.when.node for rule in rules]
    releases = [rule.until.node for rule in rules if rule.until is not None]
    others = [node for rule in rules for node in rule.nodes()]
    program = lower([*guards, *releases], also=others, margins=len(guards) if margins else 0)
    count = len(rules)
    at = iter(program.roots[count:])
    until = [-1 if rule.until is None else next(at) for rule in rules]
    parts = [np.full(1, -np.inf), program.cells, *(np.full(count, _FIRST[name]) for name in COLUMNS)]
    return RuleTable(
        names=tuple(rule.name for rule in rules),
        program=program,
        when=program.roots[:count].copy(),
        until=np.array(until, np.int32),
        margins=program.margins[:count].copy() if margins else np.empty(0, np.int32),
        hold=np.array([rule.hold - TOLERANCE for rule in rules], float),
        cooldown=np.array([rule.cooldown for rule in rules], float),
        max_hold=np.array([rule.max_hold - TOLERANCE for rule in rules], float),
        level=np.array([rule.level for rule in rules], np.uint8),
        on_invalid=np.array([INVALID_CODE[rule.on_invalid] for rule in rules], np.uint8),
        priority=np.array([rule.priority for rule in rules], np.int64),
        initial=np.concatenate([*parts, np.full(count if margins else 0, np.nan)]),
    )


def carry(values: NDArray[np.float64], old: RuleTable, new: RuleTable) -> NDArray[np.float64]:
    """Transfer the state to a new table, such as that of a changed rule file; rules of the same name keep their state.

    Temporal operators are reset, so their time windows must fill again.

    Args:
        values: State of the old table, shape (width,).
        old: Old table.
        new: New table.

    Returns:
        State of the new table, shape (width,).
    """
    state = new.start()
    state[new.part("time")] = values[old.part("time")]
    indices = {name: i for i, name in enumerate(old.names)}
    for i, name in enumerate(new.names):
        if name in indices:
            for column in COLUMNS:
                state[new.part(column)][i] = values[old.part(column)][indices[name]]
    return state
