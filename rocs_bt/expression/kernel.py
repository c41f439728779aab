"""The compiled kernel `_kernel.c`, which runs programs and tables of rules."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .program import Program

_NAME = f"{__package__}._kernel"  # imported by name, since import-linter takes a compiled module for the whole package


@cache
def kernel_missing() -> str:
    """Reason why the compiled kernel is not available; empty if it is available."""
    try:
        import_module(_NAME)
    except ImportError as error:
        if any(Path(__file__).parent.glob("_kernel*.so")):
            return f"the compiled kernel cannot be loaded ({error}); reinstall rocs_bt"
        return (
            "the kernel was not compiled when rocs_bt was installed, which needs a C compiler and Python's headers; "
            "install these, then reinstall rocs_bt"
        )
    return ""


def program_machine(program: Program) -> Any:
    """Create a machine that runs a program alone, in the initial state; all roots and margins can be read."""
    keep = np.array([*program.roots, *program.margins[program.margins >= 0]], np.int32)
    initial = np.concatenate([[-np.inf], program.cells])
    return kernel_table(program, keep, initial, *_NO_RULES).machine(initial.copy())


_NO_RULES: Any = [np.empty(0, kind) for kind in ("i4", "i4", "i4", "f8", "f8", "f8", "u1", "u1", "i8")]


def kernel_table(program: Program, keep: NDArray[np.int32], initial: NDArray[np.float64], *columns: Any) -> Any:
    """Copy a program and the columns of a rule table into the kernel, which checks them.

    Args:
        program: Register program.
        keep: Registers that can be read after a step, in addition to results of temporal operators.
        initial: Initial state.
        columns: Columns of the rules, in the order of `Table` in `_kernel.c`.

    Raises:
        ValueError: The table is malformed, or refers to a register, cell or column that does not exist.
    """
    return import_module(_NAME).Table(program.code, program.registers, keep, initial, *columns)
