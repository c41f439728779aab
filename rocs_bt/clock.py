"""Time as an injected object: simulated or wall, and rates that must divide."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass

from .errors import Fault, RateError


class Clock(ABC):
    """Where every block and every timer reads the time. Never read another one."""

    @abstractmethod
    def now(self) -> float:
        """The time since the episode began [s]."""


class SimulatedClock(Clock):
    """Time that moves only when somebody says so; counted in whole steps, so it never drifts.

    Args:
        step: The length of one step [s].
    """

    def __init__(self, step: float) -> None:
        if not step > 0.0:
            raise RateError(Fault(f"a clock's step must be positive, found {step} s."))
        self.step = step
        self._count = 0

    @property
    def count(self) -> int:
        """How many steps have passed."""
        return self._count

    def now(self) -> float:
        return self._count * self.step

    def advance(self, steps: int = 1) -> None:
        """Let time pass."""
        self._count += steps


class WallClock(Clock):
    """Real time since it was made [s]; `wait_until` sleeps, and wakes early when `stop` is set.

    Args:
        running: False lets it stand at zero until `start`, so that a run does not count what setting it up took.
    """

    def __init__(self, running: bool = True) -> None:
        self._start: float | None = None
        if running:
            self.start()

    def start(self) -> None:
        """Begin at zero, now."""
        self._start = time.monotonic()

    def now(self) -> float:
        return 0.0 if self._start is None else time.monotonic() - self._start

    def wait_until(self, deadline: float, stop: threading.Event) -> bool:
        """Sleep until the deadline [s]; True unless `stop` was set before it."""
        while (remaining := deadline - self.now()) > 0.0:
            if stop.wait(remaining):
                return False
        return not stop.is_set()


@dataclass(frozen=True)
class Rate:
    """How often something happens, as a whole number of base steps.

    Attributes:
        every: Base steps between two turns.
        step: The base step [s].
    """

    every: int
    step: float

    @property
    def period(self) -> float:
        """Time between two turns [s]."""
        return self.every * self.step

    @property
    def hz(self) -> float:
        """Turns per second [1/s]."""
        return 1.0 / self.period

    def due(self, count: int) -> bool:
        """Whether there is a turn at this base step."""
        return count % self.every == 0

    @staticmethod
    def dividing(hz: float, step: float, what: str) -> Rate:
        """The rate of `hz` turns per second over a base step.

        Args:
            hz: Turns per second [1/s].
            step: Base step [s].
            what: Whose rate it is, for the message.

        Raises:
            RateError: The period is not a whole number of steps; the message names the nearest ones that are.
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
