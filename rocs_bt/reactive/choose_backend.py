"""Choice of the back end that evaluates rules."""

from __future__ import annotations

from ..base.errors import InputError, unknown
from ..expression import kernel_missing
from .backend import Backend
from .kernel_backend import KernelBackend
from .numpy_backend import NumpyBackend


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
