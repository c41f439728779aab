"""Back end with the compiled kernel `_kernel.c`, which interprets rule tables in C."""

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
    """Reason why the compiled kernel is not available; empty if it is available."""
    try:
        from ._kernel import Table  # noqa: F401 - tests only whether it can be loaded
    except ImportError as error:
        if any(Path(__file__).parent.glob("_kernel*.so")):
            return f"the compiled kernel cannot be loaded ({error}); reinstall rocs_bt"
        return (
            "the kernel was not compiled when rocs_bt was installed, which needs a C compiler and Python's headers; "
            "install these, then reinstall rocs_bt"
        )
    return ""


class KernelBackend:
    """Back end that runs tables in the compiled kernel; available if `kernel_missing()` is empty."""

    name = "kernel"

    def __init__(self) -> None:
        self._tables: WeakKeyDictionary[RuleTable, Table] = WeakKeyDictionary()

    def machine(self, table: RuleTable) -> Machine:
        return KernelMachine(table, self._compiled(table))

    def batch_time(self, table: RuleTable, x: Floats, t: Floats, values: Floats) -> Steps:
        """Run the rules of one robot on a sequence of snapshots; see Backend. Releases the GIL."""
        return self._batch(table, x, t, values[np.newaxis])

    def batch_lanes(self, table: RuleTable, x: Floats, t: float, values: Floats) -> Steps:
        """Run one step of the rules of many robots; see Backend. Releases the GIL."""
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
        """The kernel's copy of a table, cached."""
        found = self._tables.get(table)
        if found is None:
            found = self._tables[table] = compiled(table)
        return found


def compiled(table: RuleTable) -> Table:
    """Copy a table into the kernel, which checks it.

    Raises:
        ValueError: The table is malformed, or refers to a register, cell or column that does not exist.
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
    """Rules of one robot in the kernel; see Machine.

    The kernel updates the state array in place. `mask`, `blind` and `margins` are read-only views of this array.
    """

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
        """Copy of the state; see Machine."""
        return self._values.copy()

    def restore(self, values: Floats) -> None:
        """Replace the state; see Machine."""
        self._values[:] = values
        self._machine.wake()

    def enable(self, rule: int, on: bool) -> None:
        """Enable or disable a rule; see Machine."""
        self._values[self.table.part("enabled")][rule] = on

    def _column(self, name: str) -> Sequence[float]:
        return self._values[self.table.part(name)].data.toreadonly()
