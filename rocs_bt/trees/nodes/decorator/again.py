"""Decorators that tick their child several times."""

from __future__ import annotations

from typing import Any, ClassVar

from py_trees.common import Status

from ...status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ..family import Decorator, halt, strange
from ..port import Input


class _Again(Decorator):
    """Counts how often the child came to `counted`, up to a limit; the other outcome ends it at once.

    Between two rounds of a child that is done at once it is RUNNING for a moment, so that it can be interrupted.
    """

    counted: ClassVar[Status] = SUCCESS
    limit: ClassVar[str] = ""

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._count = 0

    def halted(self) -> None:
        self._count = 0
        super().halted()

    def tick_once(self) -> Outcome:
        limit = self.read(self.limit)
        self.status = RUNNING
        child: Any = self.decorated
        while limit == -1 or self._count < limit:
            at_once = child.status is not RUNNING
            outcome = child.tick_once() or child.status
            if outcome is RUNNING:
                return outcome
            if outcome is IDLE:
                raise strange(child, outcome)
            if outcome is SKIPPED:
                halt(child)
                return outcome
            if outcome is not self.counted:
                return self._finish(outcome)
            self._count += 1
            if outcome is FAILURE:
                limit = self.read(self.limit)  # the child may have changed it; only RetryUntilSuccessful asks again
            if at_once and (limit == -1 or self._count < limit):
                self.runtime.woken = True
                return RUNNING
        return self._finish(self.counted)

    def _finish(self, outcome: Status) -> Outcome:
        self._count = 0
        self.status = outcome
        return outcome


class Repeat(_Again):
    """Ticks the child until it has succeeded `num_cycles` times; FAILURE as soon as it fails, SKIPPED if it is skipped.

    The count is kept when the child is skipped. With 0 it is SUCCESS at once.
    """

    counted = SUCCESS
    limit = "num_cycles"
    num_cycles = Input(int, doc="how often; -1 is for ever")


class RetryUntilSuccessful(_Again):
    """Ticks the child until it succeeds, `num_attempts` times at most; SKIPPED if it is skipped.

    With 0 it is FAILURE at once. The port is read again after each failure.
    """

    counted = FAILURE
    limit = "num_attempts"
    num_attempts = Input(int, doc="how often; -1 is for ever")
