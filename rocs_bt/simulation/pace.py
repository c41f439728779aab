"""Holding a simulation back to the pace of the wall clock, so that a person can follow it."""

from __future__ import annotations

import threading

from ..clock import WallClock


class Pace:
    """Called once a control period with the time [s]: waits until as much has passed on the wall. Time begins now."""

    def __init__(self) -> None:
        self._clock = WallClock()
        self._never = threading.Event()

    def __call__(self, t: float) -> bool:
        self._clock.wait_until(t, self._never)
        return True
