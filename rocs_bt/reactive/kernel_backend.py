"""Back end with the compiled kernel, which interprets rule tables in C, and the choice of it where it is compiled."""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ..base.errors import InputError, unknown
from ..expression import kernel_missing
from ..expression.kernel import kernel_table
from .backend import Backend, Floats, Machine, Steps
from .numpy_backend import NumpyBackend
from .rule_table import RuleTable


class KernelBackend:
    """Back end that runs tables in the compiled kernel; available if `kernel_missing()` is empty.

    Batches release the GIL.
    """

    name = "kernel"

    def __init__(self) -> None:
        self._tables: WeakKeyDictionary[RuleTable, Any] = WeakKeyDictionary()

    def machine(self, table: RuleTable) -> Machine:
        return KernelMachine(table, self._compiled(table))

    def batch_time(self, table: RuleTable, x: Floats, t: Floats, values: Floats) -> Steps:
        return self._batch(table, x, t, values[np.newaxis])

    def batch_lanes(self, table: RuleTable, x: Floats, t: float, values: Floats) -> Steps:
        return self._batch(table, x, np.full(len(x), t, float), values)

    def _batch(self, table: RuleTable, x: Floats, t: Floats, values: Floats) -> Steps:
        steps = Steps.empty(table, len(x))
        states = np.ascontiguousarray(values)
        snapshots, times = np.ascontiguousarray(x, float), np.ascontiguousarray(t, float)
        self._compiled(table).batch(snapshots, times, states, steps.winner, steps.mask, steps.margin)
        if states is not values:
            values[:] = states
        return steps

    def _compiled(self, table: RuleTable) -> Any:
        """The kernel's copy of a table, cached."""
        found = self._tables.get(table)
        if found is None:
            found = self._tables[table] = compiled(table)
        return found


def compiled(table: RuleTable) -> Any:
    """Copy a table into the kernel; see `kernel_table`."""
    return kernel_table(
        table.program,
        np.empty(0, np.int32),
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


class KernelMachine(Machine):
    """Rules of one robot in the kernel, which updates the state array in place; see Machine."""

    def __init__(self, table: RuleTable, handle: Any) -> None:
        super().__init__(table)
        self._machine = handle.machine(self._values)
        self.step = self._machine.step
        self.register = self._machine.register

    def restore(self, values: Floats) -> None:
        super().restore(values)
        self._machine.wake()


def choose_backend(name: str = "auto") -> Backend:
    """Create a back end by its name: `kernel`, `numpy`, or `auto` for the kernel if it is installed.

    Raises:
        InputError: The name is unknown, or the kernel is not installed.
    """
    if name not in ("auto", "kernel", "numpy"):
        raise InputError(unknown("back end", name, ["auto", "kernel", "numpy"]))
    missing = "" if name == "numpy" else kernel_missing()
    if name == "kernel" and missing:
        raise InputError(f"back end 'kernel' is not available: {missing}, or choose 'numpy'")
    return NumpyBackend() if name == "numpy" or missing else KernelBackend()
