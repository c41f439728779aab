"""The one lowered table of a rule set: a register program, and each rule's life as columns of numbers.

All back ends run this table and give the same winners, masks, margins and state, bit for bit.

**State** of one robot is one float64 array, `values` of shape (width,), so that N robots are an array (N, width), and a
rule's part can be carried into another table by its name. With C cells and R rules it holds, one after the other:

==============  ======  ========================================================================================
`time`          1       the time of the last step; -inf before the first
`cells`         C       the state of the temporal operations, as expression/program.py has it
`latched`       R       1.0 while the rule wants its action; the mask
`risen`         R       since when the guard of an open rule holds; +inf: it does not
`ready`         R       when its cooldown is over; -inf at first
`unknown`       R       since when what decides is invalid; +inf: it is valid
`enabled`       R       1.0 where the agent's mode lets the rule live; written from outside, never by a step
`blind`         R       result: 1.0 where the guard, or what decided, was invalid at this step
`margin`        R       result: how far the guard is from changing, NaN where invalid; R = 0 in a table without margins
==============  ======  ========================================================================================

**A step** of (x, t), rule by rule in the order of the table, after the program has run:

0. If t < time, everything but `enabled` becomes as it was at first. time = t.
1. If the rule is not enabled: unknown = +inf, risen = +inf, blind = 0; if it was latched it is released (5). Done.
2. guard = r[when]. decided = guard if the rule is open; else r[until], or NOT guard where until is -1.
   blind = 1 if guard or decided is NaN, else 0.
3. If decided is NaN: unknown = t if it is +inf. Where on_invalid is HOLD and t - unknown < max_hold: the rule stays
   as it is (risen too); done. decided = 1 if (on_invalid is not CLEAR) differs from (latched), else 0: TRIP and a
   HOLD that is over latch an open rule and keep a latched one, CLEAR does neither. If decided is not NaN:
   unknown = +inf.
4. Open: decided 0: risen = +inf. Decided 1: risen = t if it is +inf; if t - risen >= hold and t >= ready: latched = 1,
   risen = +inf, and for an edge rule ready = t + cooldown.
5. Latched and decided 1: latched = 0, and for a level rule ready = t + cooldown.
   `hold` and `max_hold` of the table have the tolerance of 1e-9 s taken off already; `ready` is compared as
   t >= ready - 1e-9.
6. margin = r[margins[i]] of every rule.

The winner is the latched rule of the greatest priority, the first of them in the table; -1 if none is latched.
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
    """A rule set, lowered; see the module.

    Attributes:
        names: The rules' names, R of them.
        program: What computes the guards; `program.temporal` are the values that parameters and readings may need.
        when: The guard's register, int32, (R,).
        until: The release's register, int32, (R,); -1: as soon as the guard does not hold.
        margins: The margin's register, int32, (R,), or (0,) without margins.
        hold: How long the guard must hold, less the tolerance [s], float64, (R,).
        cooldown: [s], float64, (R,).
        max_hold: How long HOLD may last, less the tolerance [s], float64, (R,).
        level: 1 for level rules, 0 for edge rules, uint8, (R,).
        on_invalid: 0 CLEAR, 1 TRIP, 2 HOLD, uint8, (R,).
        priority: int64, (R,).
        initial: The state at first, float64, (width,).
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
        """How many numbers the state of one robot has."""
        return self.initial.size

    def part(self, name: str) -> slice:
        """Where a part of the state stands: `time`, `cells`, `latched` ... `margin`."""
        cells, rules = self.program.cells.size, len(self.names)
        if name == "time":
            return slice(0, 1)
        if name == "cells":
            return slice(1, 1 + cells)
        if name == "margin":
            return slice(self.width - self.margins.size, self.width)
        start = 1 + cells + COLUMNS.index(name) * rules
        return slice(start, start + rules)

    def start(self, lanes: int | None = None) -> NDArray[np.float64]:
        """A fresh state: (width,), or (lanes, width) for that many robots."""
        return self.initial.copy() if lanes is None else np.tile(self.initial, (lanes, 1))


def lower_rules(rules: Sequence[Rule], margins: bool = False) -> RuleTable:
    """The table of some rules.

    Args:
        rules: In the order of the table.
        margins: Whether every step also computes how far each guard is from changing (robustness).
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
    """The state of a table that takes another's place: rules of the same name go on as they are.

    Temporal operations begin anew, so a window must be covered again.

    Args:
        values: The old table's state, (width,).
        old: The old table.
        new: The new one.

    Returns:
        The new table's state, (width,).
    """
    fresh = new.start()
    fresh[new.part("time")] = values[old.part("time")]
    places = {name: i for i, name in enumerate(old.names)}
    for i, name in enumerate(new.names):
        if name in places:
            for column in COLUMNS:
                fresh[new.part(column)][i] = values[old.part(column)][places[name]]
    return fresh
