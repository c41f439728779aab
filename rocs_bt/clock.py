"""Time as an injected object (simulated or wall clock), and rates as whole numbers of base steps."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass

from .errors import Fault, RateError


class Clock(ABC):
    """Source of time for every block and timer; they read no other clock."""

    @abstractmethod
    def now(self) -> float:
        """Time since the start of the episode [s]."""


class SimulatedClock(Clock):
    """Time that only `advance` moves; counted in whole steps, so it does not drift.

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
    """Real time since `start` [s].

    Args:
        running: Whether the clock starts at once. If False it reads zero until `start`, so that set-up time is not
            counted as part of the run.
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

    def wait_until(self, deadline: float, stop: threading.Event) -> bool:
        """Sleep until the deadline [s] or until `stop` is set; True unless `stop` was set."""
        while (remaining := deadline - self.now()) > 0.0:
            if stop.wait(remaining):
                return False
        return not stop.is_set()


@dataclass(frozen=True)
class Rate:
    """Rate of a periodic task, as a whole number of base steps per period.

    Attributes:
        every: Base steps per period.
        step: Base step [s].
    """

    every: int
    step: float

    @property
    def period(self) -> float:
        """Time between two executions [s]."""
        return self.every * self.step

    @property
    def hz(self) -> float:
        """Executions per second [1/s]."""
        return 1.0 / self.period

    def due(self, count: int) -> bool:
        """Whether the task runs at this base step."""
        return count % self.every == 0

    @staticmethod
    def dividing(hz: float, step: float, what: str) -> Rate:
        """The rate of `hz` executions per second over a base step.

        Args:
            hz: Executions per second [1/s].
            step: Base step [s].
            what: Name of the rate, for the message.

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
