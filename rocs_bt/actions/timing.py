"""Timing of actions that command the same motion for a time or until a condition holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..interfaces.action import Body, Progress


@dataclass
class HoldTimer:
    """Timer of an action that holds a command."""

    _begun: float | None = None

    def over(self, body: Body, duration: float, until: Callable[[Body], bool] | None) -> bool:
        """Whether the action has ended before this period: the time is over [s], or the condition holds."""
        now = body.clock.now()
        if self._begun is None:
            self._begun = now
        return now - self._begun >= duration or (until is not None and until(body))

    def progress(self, body: Body, duration: float) -> Progress:
        """Progress after the command of this period; the action succeeds in its last period."""
        elapsed = body.clock.now() - (self._begun or 0.0)
        # Half a period of tolerance absorbs the jitter of real time and rounds the duration to whole periods.
        return Progress.SUCCEEDED if elapsed + 1.5 * body.period > duration else Progress.RUNNING
