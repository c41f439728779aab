"""Small functions that a compiled module may stand in for, where there was a C compiler when rocs_bt was installed."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

PLAIN: dict[str, Callable[..., Any]] = {}
"""The functions as Python has them, by name: what the compiled ones are held against, to the bit."""


def compiled_missing() -> str:
    """Why the plain functions run here; empty where the compiled ones do."""
    try:
        kernel = import_module("._numbers", __package__)
    except ImportError as error:
        return f"{error}; that takes a C compiler and Python's headers when rocs_bt is installed"
    lacking = [name for name in PLAIN if not hasattr(kernel, name)]
    return f"the kernel is of another version, without {', '.join(lacking)}; install rocs_bt again" if lacking else ""


def compiled(plain: F) -> F:
    """The function of the same name in `_numbers.c`, or the plain one where that was not compiled; by position only."""
    if PLAIN.setdefault(plain.__name__, plain).__module__ != plain.__module__:
        raise ValueError(f"a compiled function named '{plain.__name__}' stands in {PLAIN[plain.__name__].__module__}.")
    try:
        kernel = import_module("._numbers", __package__)
    except ImportError:
        return plain
    fast: F = getattr(kernel, plain.__name__, plain)
    return fast
