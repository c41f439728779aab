"""Rules in the compiled table machine, `_kernel.c`: at the speed of hand-written C, and in batches without the GIL."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from .backend import Floats, Machine, Steps
from .rule_table import RuleTable

if TYPE_CHECKING:
    from ._kernel import Table


def kernel_missing() -> str:
    """Why the compiled kernel cannot be used here; empty where it can."""
    try:
        from ._kernel import Table  # noqa: F401 - only whether it can be loaded is asked
    except ImportError as error:
        if any(Path(__file__).parent.glob("_kernel*.so")):
            return f"the compiled kernel cannot be loaded ({error}); install rocs_bt again"
        return (
            "the kernel was not compiled when rocs_bt was installed, which takes a C compiler and Python's headers; "
            "install those, then rocs_bt again"
        )
    return ""


class KernelBackend:
    """Runs tables in the compiled kernel, which is there where `kernel_missing()` is empty."""

    name = "kernel"

    def __init__(self) -> None:
        self._tables: WeakKeyDictionary[RuleTable, Table] = WeakKeyDictionary()

    def machine(self, table: RuleTable) -> Machine:
        return KernelMachine(table, self._compiled(table))

    def batch_time(self, table: RuleTable, x: Floats, t: Floats, values: Floats) -> Steps:
        """One robot over time; see Backend. Other threads go on meanwhile."""
        return self._batch(table, x, t, values[np.newaxis])

    def batch_lanes(self, table: RuleTable, x: Floats, t: float, values: Floats) -> Steps:
        """Many robots at one time; see Backend. Other threads go on meanwhile."""
        return self._batch(table, x, np.full(len(x), t, float), values)

    def _batch(self, table: RuleTable, x: Floats, t: Floats, values: Floats) -> Steps:
        count = len(x)
        steps = Steps(
            winner=np.empty(count, np.int32),
            mask=np.empty((count, len(table.names)), bool),
            margin=np.empty((count, table.margins.size)),
        )
        states = np.ascontiguousarray(values)
        snapshots, times = np.ascontiguousarray(x, float), np.ascontiguousarray(t, float)
        self._compiled(table).batch(snapshots, times, states, steps.winner, steps.mask, steps.margin)
        if states is not values:
            values[:] = states
        return steps

    def _compiled(self, table: RuleTable) -> Table:
        """The table as the kernel has it, made once."""
        found = self._tables.get(table)
        if found is None:
            found = self._tables[table] = compiled(table)
        return found


def compiled(table: RuleTable) -> Table:
    """A table, checked and copied into the kernel.

    Raises:
        ValueError: It names a register, cell or column that does not exist, or is no table at all.
    """
    from ._kernel import Table

    return Table(
        table.program.code,
        table.program.registers,
        table.initial,
        table.when,
        table.until,
        table.margins,
        table.hold,
        table.cooldown,
        table.max_hold,
        table.level,
        table.on_invalid,
        table.priority,
    )


class KernelMachine:
    """One robot's rules; see Machine. The kernel works on the state itself, which is looked at but not copied here."""

    def __init__(self, table: RuleTable, handle: Table) -> None:
        self.table = table
        self._values = table.start()
        self._machine = handle.machine(self._values)
        self.step = self._machine.step
        self.register = self._machine.register
        self.mask = self._column("latched")
        self.blind = self._column("blind")
        self.margins = self._column("margin")

    def values(self) -> Floats:
        """A copy of the state."""
        return self._values.copy()

    def restore(self, values: Floats) -> None:
        """Go on from a state."""
        self._values[:] = values
        self._machine.wake()

    def enable(self, rule: int, on: bool) -> None:
        """Let a rule live, or not."""
        self._values[self.table.part("enabled")][rule] = on

    def _column(self, name: str) -> Sequence[float]:
        return self._values[self.table.part(name)].data.toreadonly()
