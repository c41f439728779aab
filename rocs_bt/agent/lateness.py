"""Lateness: delays of one block, and when they count as a failure."""

from __future__ import annotations

import os
from collections import deque
from contextlib import suppress

MOST = 5
"""Number of delays within `WINDOW` that are tolerated."""

WINDOW = 10.0
"""Time in which delays are counted [s]."""

LONGEST = 1.0
"""Duration of a delay that is tolerated [s]."""


class Lateness:
    """Delays of one block, in beats of the heartbeat.

    Beats are counted, and not seconds: if the whole process gets no CPU time, the heartbeat does not run either.

    Args:
        beat: Interval between two beats [s].
    """

    def __init__(self, beat: float) -> None:
        self.late = False
        self._beat = beat
        self._beats = 0
        self._begun: deque[float] = deque()  # [s] times at which delays began

    def after(self, late: bool, now: float) -> str:
        """Count a beat; returns the reason why the block has failed, or an empty text.

        Args:
            late: Whether the block is late in this beat.
            now: Present time [s].
        """
        if not late:
            self.late, self._beats = False, 0
            return ""
        if not self.late:
            self.late = True
            self._begun.append(now)
        while self._begun and self._begun[0] < now - WINDOW:
            self._begun.popleft()
        self._beats += 1
        if len(self._begun) > MOST:
            return f"it was late {len(self._begun)} times in {WINDOW:g} s"
        return f"it was late for more than {LONGEST:g} s" if self._beats * self._beat > LONGEST + 1e-9 else ""


def load() -> str:
    """Load of the machine in words, such as ` (load 5.2 on 2 processors)`; empty where the system does not tell."""
    with suppress(OSError, AttributeError):
        return f" (load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors)"
    return ""
