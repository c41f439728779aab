"""Decorators that read the clock of their tree."""

from __future__ import annotations

from typing import Any

from ...status import FAILURE, RUNNING, SKIPPED, Outcome
from ..family import Decorator, halt
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

    def _tell(self, outcome: Outcome) -> Outcome:
        if outcome is not SKIPPED:
            if outcome is not RUNNING:
                self._deadline = None
            self.status = outcome
        return outcome


class Timeout(_Timed):
    """FAILURE, and the child is halted, when it has been RUNNING for `msec` milliseconds; 0 is no limit."""

    msec = Input(int, doc="how long the child may run [ms]")

    def tick_once(self) -> Outcome:
        limit = self.msec
        if limit <= 0:
            self.status = RUNNING
            return self._tell(self.tick_child())
        if self._due(limit) and self.decorated.status is RUNNING:
            halt(self.decorated)
            self.feedback_message = f"after {limit} ms"
            return self._tell(FAILURE)
        return self._tell(self.tick_child())


class Delay(_Timed):
    """RUNNING for `delay_msec` milliseconds; then the child is ticked."""

    delay_msec = Input(int, doc="how long to wait [ms]")

    def tick_once(self) -> Outcome:
        if not self._due(self.delay_msec):
            self.status = RUNNING
            return RUNNING
        return self._tell(self.tick_child())
