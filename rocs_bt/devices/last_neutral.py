"""Neutral at the end of a run on hardware, sent several times."""

from __future__ import annotations

import time
from collections.abc import Callable

REPEATS = 3
"""Number of neutral commands at the end; several, because a driver's datagram may be lost."""

PAUSE = 0.02
"""Pause after each of these commands [s]."""


def repeat_neutral(neutral: Callable[[], None]) -> None:
    """Send devices to neutral `REPEATS` times, by a function that does not raise."""
    for _ in range(REPEATS):
        neutral()
        time.sleep(PAUSE)
