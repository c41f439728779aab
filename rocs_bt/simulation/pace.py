"""Real-time pacing of a simulation, so that a person can watch it."""

from __future__ import annotations

import threading

from ..clock import WallClock

_FORGIVE = 0.25  # [s] delay above which the lost time is not caught up


class Pace:
    """Observer of a run that is called with the simulated time [s] and waits until the wall clock has reached it.

    Time that the run has lost, as by a pause, is not caught up.
    """

    def __init__(self) -> None:
        self._clock = WallClock()
        self._never = threading.Event()
        self._lost = 0.0

    def __call__(self, t: float) -> bool:
        self._clock.wait_until(t + self._lost, self._never)
        if self._clock.now() - t - self._lost > _FORGIVE:
            self._lost = self._clock.now() - t
        return True
