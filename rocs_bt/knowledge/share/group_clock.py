"""GroupClock: a calendar that may be wrong, kept with those of the peers."""

from __future__ import annotations

import math
from collections.abc import Callable

from ...clock import Clock
from .replica import STAMP_LIMIT

DRIFT = 1.0
"""[s] By which a clock may be behind a peer's before it follows it: more than a beat takes on its way."""


class GroupClock:
    """Calendar time that follows the fastest calendar of a group.

    Stamps of writes come from it. A robot whose calendar is years behind would otherwise lose every conflict with a
    peer, however much later it writes. The calendar is read once, and the agent's own clock counts from then on:
    setting the calendar during a run changes nothing.

    Args:
        calendar: Time since an epoch that all peers share [s].
        clock: The agent's clock; it runs when `now` is first read.

    Attributes:
        ahead: Correction so far [s], never negative.
    """

    def __init__(self, calendar: Callable[[], float], clock: Clock) -> None:
        self.ahead = 0.0
        self._calendar = calendar
        self._clock = clock
        self._start: float | None = None  # [s] calendar at zero of the agent's clock

    def now(self) -> float:
        """Calendar time of the group, as far as it is known [s]."""
        if self._start is None:
            self._start = self._calendar() - self._clock.now()
        return self._start + self._clock.now() + self.ahead

    def follow(self, time: float) -> float:
        """Follow a peer's calendar time [s] if it is ahead by more than `DRIFT`.

        Returns:
            Correction [s]; 0 for none.
        """
        behind = time - self.now()
        if behind <= DRIFT:
            return 0.0
        self.ahead += behind
        return behind


def is_calendar(time: float, ahead: float) -> bool:
    """Whether a peer's calendar time and its correction [s] can be true."""
    return 0.0 <= time < STAMP_LIMIT * 0.5e-6 and 0.0 <= ahead < math.inf
