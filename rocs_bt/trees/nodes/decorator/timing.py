"""Decorators that read the clock of their tree."""

from __future__ import annotations

from typing import Any

from ...status import FAILURE, IDLE, RUNNING, SKIPPED, Outcome
from ..family import Decorator, halt, strange
from ..port import Input

FORGIVEN = 1e-9
"""A nanosecond [s] forgives the rounding of k * step."""


class _Timed(Decorator):
    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._deadline: float | None = None

    def halted(self) -> None:
        self._deadline = None
        super().halted()

    def _due(self, milliseconds: int) -> bool:
        """Whether that much time has passed since this was asked first."""
        now = self.runtime.now()
        if self._deadline is None:
            self._deadline = now + milliseconds / 1000.0
            self.status = RUNNING
        return now >= self._deadline - FORGIVEN

    def _ended(self, outcome: Outcome) -> Outcome:
        """End, unless the child was skipped.

        Raises:
            TreeError: It has no outcome.
        """
        if outcome is IDLE:
            raise strange(self.decorated, outcome)
        if outcome is not SKIPPED:
            self._deadline = None
            self.status = outcome
        return outcome


class Timeout(_Timed):
    """FAILURE, and the child is halted, when it has been RUNNING for `msec` milliseconds; 0 is no limit."""

    msec = Input(int, doc="how long the child may run [ms]")

    def tick_once(self) -> Outcome:
        child: Any = self.decorated
        limit = self.read("msec")
        if limit <= 0:
            self.status = RUNNING
        elif self._due(limit) and child.status is RUNNING:
            halt(child)
            self.feedback_message = f"after {limit} ms"
            return self._ended(FAILURE)
        outcome = child.tick_once() or child.status
        return outcome if outcome is RUNNING else self._ended(outcome)


class Delay(_Timed):
    """RUNNING for `delay_msec` milliseconds; then the child is ticked."""

    delay_msec = Input(int, doc="how long to wait [ms]")

    def tick_once(self) -> Outcome:
        if not self._due(self.delay_msec):
            self.status = RUNNING
            return RUNNING
        child: Any = self.decorated
        outcome = child.tick_once() or child.status
        return outcome if outcome is RUNNING else self._ended(outcome)
