"""Waiting for other threads and processes, without a time in which they must be ready."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

GUARD = 120.0
"""[s] Time-out of a wait that always ends; only a defect lets it pass."""

TURN = 0.005
"""[s] Pause between two looks."""

TURNS = 12_000
"""Looks before the wait is given up. They are counted, so a machine that stops for a while takes none away."""


def until(condition: Callable[[], T]) -> T:
    """Look until a condition holds, and return what it returned.

    Raises:
        AssertionError: It did not hold within `TURNS` looks.
    """
    for _ in range(TURNS):
        if found := condition():
            return found
        time.sleep(TURN)
    raise AssertionError(f"it did not come true within {TURNS} looks")
