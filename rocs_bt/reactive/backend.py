"""Interfaces of the back ends that run a RuleTable.

All back ends give bit-identical results, as specified in `rule_table`. A Machine runs the rules of one robot step by
step. The batch methods are for recordings (one robot over time) and fleets (many robots at one time).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .rule_table import RuleTable

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Steps:
    """Results of n evaluations of a rule table.

    Attributes:
        winner: Index of the latched rule with the highest priority, -1 for none, int32, shape (n,).
        mask: Whether each rule was latched, bool, shape (n, R).
        margin: Robustness margins of the guards, NaN if invalid, float64, shape (n, R); (n, 0) from a table without
            margins.
    """

    winner: NDArray[np.int32]
    mask: NDArray[np.bool_]
    margin: Floats

    @classmethod
    def empty(cls, table: RuleTable, count: int) -> Steps:
        """Arrays for `count` evaluations of a table, to be filled."""
        return cls(
            np.empty(count, np.int32), np.empty((count, len(table.names)), bool), np.empty((count, table.margins.size))
        )


class Machine:
    """Rules of one robot, run step by step.

    Attributes:
        table: Table that the machine runs.
        mask: Nonzero for each rule that is latched, shape (R,); this and the next two change with each step.
        blind: Nonzero for each rule with an invalid guard or release condition, shape (R,).
        margins: Robustness margins of the guards, NaN if invalid, shape (R,); empty if the table has no margins.
        step: Advances all rules by a snapshot, shape (size,), in SI units, NaN for invalid values, and its time [s];
            returns the index of the latched rule with the highest priority, -1 for none.
        register: Value of a register of the table's program; truth values are 1.0 or 0.0, invalid values NaN.
    """

    step: Callable[[Floats, float], int]
    register: Callable[[int], float]

    def __init__(self, table: RuleTable) -> None:
        self.table = table
        self._values = table.start()
        self.mask, self.blind, self.margins = map(self._column, ("latched", "blind", "margin"))

    def values(self) -> Floats:
        """Copy of the state of all rules, shape (width,); `rule_table` describes its layout."""
        return self._values.copy()

    def restore(self, values: Floats) -> None:
        """Replace the state of all rules by one that `values` returned."""
        self._values[:] = values

    def enable(self, rule: int, on: bool) -> None:
        """Enable or disable a rule, by its index in the table, from the next step on."""
        self._values[self.table.part("enabled")][rule] = on

    def _column(self, name: str) -> Sequence[float]:
        return self._values[self.table.part(name)].data.toreadonly()


class Backend(Protocol):
    """Interface of an implementation that evaluates rule tables (`RuleTable`)."""

    @property
    def name(self) -> str:
        """Name of the back end, such as `numpy`."""
        ...

    def machine(self, table: RuleTable) -> Machine:
        """Create a machine for a table, in the initial state."""
        ...

    def batch_time(self, table: RuleTable, x: Floats, t: Floats, values: Floats) -> Steps:
        """Run the rules of one robot on a sequence of n snapshots.

        Args:
            table: Table of the rules.
            x: Snapshots, shape (n, size).
            t: Times of the snapshots, shape (n,) [s].
            values: Initial state, shape (width,); advanced in place.
        """
        ...

    def batch_lanes(self, table: RuleTable, x: Floats, t: float, values: Floats) -> Steps:
        """Run one step of the rules of n robots, all at the same time.

        Args:
            table: Table of the rules.
            x: Snapshots, one per robot, shape (n, size).
            t: Time of the snapshots [s].
            values: States, shape (n, width); advanced in place.
        """
        ...
