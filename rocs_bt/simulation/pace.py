"""Real-time pacing of a simulation, so that a person can watch it."""

from __future__ import annotations

import threading

from ..clock import WallClock


class Pace:
    """Observer of a run that is called with the simulated time [s] and waits until the wall clock has reached it.

    The wall clock starts at zero when the object is constructed.
    """

    def __init__(self) -> None:
        self._clock = WallClock()
        self._never = threading.Event()

    def __call__(self, t: float) -> bool:
        self._clock.wait_until(t, self._never)
        return True
