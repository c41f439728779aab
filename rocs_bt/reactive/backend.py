"""Back ends: what runs a RuleTable. All give the same, bit for bit; `rule_table` says what.

A Machine is one robot's rules, live. The batch methods serve recordings (one robot over time) and fleets (many robots
at one time).
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
    """What n steps gave.

    Attributes:
        winner: The winner's index in the table, -1 for none, int32, (n,).
        mask: Which rules were latched, bool, (n, R).
        margin: The guards' margins, float64, (n, R), NaN where not known; (n, 0) from a table without margins.
    """

    winner: NDArray[np.int32]
    mask: NDArray[np.bool_]
    margin: Floats


class Machine(Protocol):
    """One robot's rules, live. What is read of it is of the last step, and valid until the next."""

    @property
    def table(self) -> RuleTable:
        """What it runs."""
        ...

    @property
    def mask(self) -> Sequence[float]:
        """Which rules are latched, (R,): not 0 where one is."""
        ...

    @property
    def blind(self) -> Sequence[float]:
        """Where the guard, or what decided, was invalid, (R,)."""
        ...

    @property
    def margins(self) -> Sequence[float]:
        """The guards' margins, (R,), NaN where not known; empty without margins."""
        ...

    def step(self, x: Floats, t: float) -> int:
        """Advance every rule.

        Args:
            x: The snapshot, (size,) in SI units, NaN where invalid.
            t: Its time [s], finite.

        Returns:
            The winner's index in the table; -1 for none.
        """
        ...

    def register(self, index: int) -> float:
        """A register of the program; a truth value is 1.0 or 0.0, NaN is invalid."""
        ...

    def values(self) -> Floats:
        """A copy of the state, (width,)."""
        ...

    def restore(self, values: Floats) -> None:
        """Go on from a state, (width,)."""
        ...

    def enable(self, rule: int, on: bool) -> None:
        """Let a rule live, or not, from the next step on."""
        ...


class Backend(Protocol):
    """A way to run tables."""

    @property
    def name(self) -> str:
        """Such as `python`."""
        ...

    def machine(self, table: RuleTable) -> Machine:
        """A machine at the beginning."""
        ...

    def batch_time(self, table: RuleTable, x: Floats, t: Floats, values: Floats) -> Steps:
        """One robot over time.

        Args:
            table: The rules.
            x: The snapshots, (n, size).
            t: Their times [s], (n,).
            values: The state at the beginning, (width,); it is advanced in place.
        """
        ...

    def batch_lanes(self, table: RuleTable, x: Floats, t: float, values: Floats) -> Steps:
        """Many robots at one time.

        Args:
            table: The rules.
            x: The snapshots, (n, size).
            t: Their time [s].
            values: Their states, (n, width); they are advanced in place.
        """
        ...


class OneByOne:
    """The batch methods of a back end that has nothing better than its machine."""

    def machine(self, table: RuleTable) -> Machine:
        """A machine at the beginning."""
        raise NotImplementedError

    def batch_time(self, table: RuleTable, x: Floats, t: Floats, values: Floats) -> Steps:
        """One robot over time; see Backend."""
        machine = self.machine(table)
        machine.restore(values)
        rows = [_row(machine, *row) for row in zip(x, t.tolist(), strict=True)]
        values[:] = machine.values()
        return _steps(table, rows)

    def batch_lanes(self, table: RuleTable, x: Floats, t: float, values: Floats) -> Steps:
        """Many robots at one time; see Backend."""
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
