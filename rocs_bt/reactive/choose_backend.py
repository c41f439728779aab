"""Choice of the back end that evaluates rules."""

from __future__ import annotations

from ..base.errors import InputError, unknown
from .backend import Backend
from .kernel_backend import KernelBackend, kernel_missing
from .python_backend import PythonBackend


def choose_backend(name: str = "auto") -> Backend:
    """Create a back end by its name: `kernel`, `python`, or `auto` for the faster one that is installed.

    Raises:
        InputError: The name is unknown, or the kernel is not installed.
    """
    if name not in ("auto", "kernel", "python"):
        raise InputError(unknown("back end", name, ["auto", "kernel", "python"]))
    missing = "" if name == "python" else kernel_missing()
    if name == "kernel" and missing:
        raise InputError(f"back end 'kernel' is not available: {missing}, or choose 'python'")
    return PythonBackend() if name == "python" or missing else KernelBackend()
