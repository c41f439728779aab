"""JumpDetector: changes between two samples of an odometry that no motion of the robot explains."""

from __future__ import annotations

import math
from collections.abc import Sequence

FACTOR = 3.0
"""Ratio of the fastest plausible motion to the robot's speed limit, as a robot may be pushed or slide."""

JUMP, TURN_JUMP = 0.3, 0.5
"""Changes between two samples that are no jump, whatever the time between them [m] and [rad]."""


class JumpDetector:
    """Jumps of the values of a sensor since its first sample.

    A jump that is undone by a later one, such as a single wrong sample, does not count any more.

    Args:
        limit: Largest plausible rate of change [1/s].
        slack: Change between two samples that is always plausible.
        period: Period of an angle; +inf for values without one.
    """

    def __init__(self, limit: float, slack: float, period: float = math.inf) -> None:
        self._limit = FACTOR * limit
        self._slack = slack
        self._period = period
        self._last: tuple[float, ...] = ()
        self._stamp = math.nan
        self._jumped: list[float] = []

    def after(self, values: Sequence[float], stamp: float) -> tuple[float, float]:
        """Take a sample.

        Args:
            values: Values of the sample, finite, shape (n,).
            stamp: Time of the sample [s].

        Returns:
            Size of the jump in this sample, 0 without one; and size of all jumps so far, 0 if they cancel out.
        """
        if len(values) != len(self._last):
            self._last, self._stamp, self._jumped = tuple(values), stamp, [0.0] * len(values)
            return 0.0, 0.0
        if stamp <= self._stamp:
            return 0.0, self._total()
        change = [self._wrapped(new - old) for new, old in zip(values, self._last, strict=True)]
        allowed = self._slack + self._limit * (stamp - self._stamp)
        self._last, self._stamp = tuple(values), stamp
        if (size := math.hypot(*change)) <= allowed:
            return 0.0, self._total()
        self._jumped = [self._wrapped(sum(pair)) for pair in zip(self._jumped, change, strict=True)]
        if self._total() <= allowed:  # undone, but for the motion meanwhile, which must not add up over many jumps
            self._jumped = [0.0] * len(change)
        return size, self._total()

    def reason(self, values: Sequence[float], stamp: float) -> str:
        """Take a sample of a continuous frame; returns why it is invalid, empty if it is not."""
        total = self.after(values, stamp)[1]
        unit = "m" if math.isinf(self._period) else "rad"
        return f"it jumped by {total:.2f} {unit}, faster than the robot can move" if total else ""

    def _total(self) -> float:
        return math.hypot(*self._jumped)

    def _wrapped(self, change: float) -> float:
        return change if math.isinf(self._period) else math.remainder(change, self._period)
