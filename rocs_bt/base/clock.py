"""Clocks, simulated or real, which are passed to all code that needs the time; and rates in whole base steps."""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

from .errors import Fault, RateError


class Clock(ABC):
    """Source of time for all blocks and timers of a run, which use no other clock."""

    @abstractmethod
    def now(self) -> float:
        """Time since the start of the episode [s]."""


class SimulatedClock(Clock):
    """Simulated time, which only `advance` moves. It is counted in whole steps, so rounding errors do not add up.

    Args:
        step: Length of one step [s].
    """

    def __init__(self, step: float) -> None:
        if not step > 0.0:
            raise RateError(Fault(f"a clock's step must be positive, found {step} s."))
        self.step = step
        self._count = 0

    @property
    def count(self) -> int:
        """Number of steps since the start."""
        return self._count

    def now(self) -> float:
        return self._count * self.step

    def advance(self, steps: int = 1) -> None:
        """Advance the time by a number of steps."""
        self._count += steps


class WallClock(Clock):
    """Real time since the call of `start` [s]; base class of clocks that run by themselves.

    Args:
        running: Whether the clock starts at once. If False, its time is 0 until `start`, so that the time of the set-up
            does not count as part of the run.
    """

    def __init__(self, running: bool = True) -> None:
        self._start: float | None = None
        if running:
            self.start()

    def start(self) -> None:
        """Start, or restart, the clock at zero."""
        self._start = time.monotonic()

    def now(self) -> float:
        return 0.0 if self._start is None else time.monotonic() - self._start

    def wall_time(self, duration: float) -> float:
        """Wall-clock time that a duration on this clock takes at present [s]."""
        return duration

    def wait_until(self, deadline: float, stop: threading.Event, patience: float = math.inf) -> bool:
        """Sleep until a time on this clock, until `stop` is set, or until the patience is over.

        Args:
            deadline: Time on this clock [s].
            stop: Event that ends the sleep.
            patience: Maximum wall-clock time to sleep [s], for clocks that may stop.

        Returns:
            False if `stop` is set.
        """
        deadline = min(deadline, self.now() + patience)
        while (remaining := deadline - self.now()) > 0.0:
            if stop.wait(remaining):
                return False
        return not stop.is_set()


SLICE = 0.05
"""Maximum interval between two checks for a signal that ends the run, on wall time [s]."""


def wait_until(
    clock: WallClock,
    deadline: float,
    stop: threading.Event,
    ended: Callable[[], str],
    meanwhile: Callable[[], object] = lambda: None,
) -> bool:
    """Sleep until a deadline, or until a signal ends the run; returns False if `stop` was set.

    Args:
        clock: Wall clock.
        deadline: Time to wake [s].
        stop: Event that ends the sleep.
        ended: Returns the reason of a signal that ends the run, or an empty text.
        meanwhile: Called after each `SLICE` of wall time that does not reach the deadline, as a simulator's clock may
            stop; an exception ends the sleep.
    """
    while not ended() and clock.now() < deadline:
        if not clock.wait_until(deadline, stop, SLICE):
            return False
        if clock.now() < deadline:
            meanwhile()
    return not stop.is_set()


@dataclass(frozen=True)
class Rate:
    """Rate of a periodic task, with a period of a whole number of base steps.

    Attributes:
        every: Number of base steps per period.
        step: Duration of a base step [s].
    """

    every: int
    step: float

    @property
    def period(self) -> float:
        """Time between two executions [s]."""
        return self.every * self.step

    @property
    def hz(self) -> float:
        """Rate in executions per second [Hz]."""
        return 1.0 / self.period

    def due(self, count: int) -> bool:
        """Whether the task runs in the base step with this number."""
        return count % self.every == 0

    @staticmethod
    def dividing(hz: float, step: float, what: str) -> Rate:
        """Create the rate of `hz` executions per second.

        Args:
            hz: Rate [Hz].
            step: Duration of a base step [s].
            what: Name of the rate, for messages.

        Raises:
            RateError: The period is not a whole number of steps; the message names the nearest possible rates.
        """
        if not hz > 0.0:
            raise RateError(Fault(f"{what} must be positive, found {hz:g} Hz."))
        steps = 1.0 / (hz * step)
        whole = round(steps)
        if whole < 1 or abs(steps - whole) > 1e-6 * steps:
            low, high = max(1, int(steps)), max(1, int(steps)) + 1
            raise RateError(
                Fault(
                    f"{what} of {hz:g} Hz is {steps:.4g} steps of {step:g} s, which is not a whole number.",
                    hint=f"Use {1.0 / (high * step):.6g} Hz or {1.0 / (low * step):.6g} Hz.",
                )
            )
        return Rate(whole, step)
