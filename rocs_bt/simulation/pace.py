"""Pace of a simulation against the wall clock."""

from __future__ import annotations

import threading
from collections.abc import Callable

from ..base.clock import WallClock, wait_until

_FORGIVE = 0.25  # [s] delay above which the lost time is not caught up


class Pace:
    """Observer of a simulation that is called with the simulated time [s] and waits until it is due.

    A rate of 0 is as fast as possible.

    Attributes:
        skipped: Wall-clock time that was lost, as by a pause, and not caught up [s].
    """

    def __init__(self, rate: float = 1.0, ended: Callable[[], str] = lambda: "") -> None:
        self.skipped = 0.0
        self._rate, self._ended = rate, ended
        self._wall, self._never = WallClock(), threading.Event()

    @property
    def passed(self) -> float:
        """Wall-clock time since the start [s]."""
        return self._wall.now()

    def __call__(self, t: float) -> bool:
        if self._rate > 0.0:
            due = t / self._rate + self.skipped
            wait_until(self._wall, due, self._never, self._ended)
            late = self._wall.now() - due
            self.skipped += late if late > _FORGIVE else 0.0
        return True
