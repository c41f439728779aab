"""Interfaces of the back ends that run a RuleTable.

All back ends give bit-identical results, as specified in `rule_table`. A Machine runs the rules of one robot step by
step. The batch methods are for recordings (one robot over time) and fleets (many robots at one time).
"""

from __future__ import annotations

from collections.abc import Sequence
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


class Machine(Protocol):
    """Rules of one robot, run step by step. The properties give the results of the last step, until the next one."""

    @property
    def table(self) -> RuleTable:
        """Table that the machine runs."""
        ...

    @property
    def mask(self) -> Sequence[float]:
        """Nonzero for each rule that is latched, shape (R,)."""
        ...

    @property
    def blind(self) -> Sequence[float]:
        """Nonzero for each rule with an invalid guard or release condition, shape (R,)."""
        ...

    @property
    def margins(self) -> Sequence[float]:
        """Robustness margins of the guards, NaN if invalid, shape (R,); empty if the table has no margins."""
        ...

    def step(self, x: Floats, t: float) -> int:
        """Advance all rules.

        Args:
            x: Snapshot, SI units, NaN for invalid values, shape (size,).
            t: Time of the snapshot, finite [s].

        Returns:
            Index of the latched rule with the highest priority; -1 for none.
        """
        ...

    def register(self, index: int) -> float:
        """Value of a register of the table's program; truth values are 1.0 or 0.0, invalid values NaN."""
        ...

    def values(self) -> Floats:
        """Copy of the state of all rules, shape (width,); `rule_table` describes its layout."""
        ...

    def restore(self, values: Floats) -> None:
        """Replace the state of all rules.

        Args:
            values: State, as returned by `values`, shape (width,).
        """
        ...

    def enable(self, rule: int, on: bool) -> None:
        """Enable or disable a rule from the next step on.

        Args:
            rule: Index of the rule in the table.
            on: Whether the rule is enabled.
        """
        ...


class Backend(Protocol):
    """Interface of an implementation that evaluates rule tables (`RuleTable`)."""

    @property
    def name(self) -> str:
        """Name of the back end, such as `python`."""
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


class SequentialBatch:
    """Base of a back end without fast batch methods: they step a machine once for each snapshot."""

    def machine(self, table: RuleTable) -> Machine:
        """Create a machine for a table, in the initial state."""
        raise NotImplementedError

    def batch_time(self, table: RuleTable, x: Floats, t: Floats, values: Floats) -> Steps:
        """Run the rules of one robot on a sequence of snapshots; see Backend."""
        machine = self.machine(table)
        machine.restore(values)
        rows = [_row(machine, *row) for row in zip(x, t.tolist(), strict=True)]
        values[:] = machine.values()
        return _steps(table, rows)

    def batch_lanes(self, table: RuleTable, x: Floats, t: float, values: Floats) -> Steps:
        """Run one step of the rules of many robots; see Backend."""
        machine, rows = self.machine(table), []
        for lane, state in zip(x, values, strict=True):
            machine.restore(state)
            rows.append(_row(machine, lane, t))
            state[:] = machine.values()
        return _steps(table, rows)


_Row = tuple[int, list[bool], list[float]]


def _row(machine: Machine, x: Floats, t: float) -> _Row:
    winner = machine.step(x, t)
    return winner, [bool(on) for on in machine.mask], list(machine.margins)


def _steps(table: RuleTable, rows: Sequence[_Row]) -> Steps:
    count = len(rows)
    return Steps(
        winner=np.array([row[0] for row in rows], np.int32),
        mask=np.array([row[1] for row in rows], bool).reshape(count, len(table.names)),
        margin=np.array([row[2] for row in rows], float).reshape(count, table.margins.size),
    )
