"""RunOnce: the child has one run in the life of the tree."""

from __future__ import annotations

from typing import Any

from ...status import IDLE, RUNNING, SKIPPED, Outcome
from ..family import Decorator
from ..port import Input


class RunOnce(Decorator):
    """Ticks the child until it has ended; from then on it is SKIPPED, or what the child came to, and never reset."""

    then_skip = Input(bool, True, "whether it is skipped afterwards")

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._outcome: Outcome | None = None

    def tick_once(self) -> Outcome:
        if self._outcome is not None:
            outcome = SKIPPED if self.then_skip else self._outcome
            self.status = IDLE if outcome is SKIPPED else outcome
            return outcome
        self.status = RUNNING
        outcome = self.tick_child()
        if outcome is not SKIPPED:
            self.status = outcome
            if outcome is not RUNNING:
                self._outcome = outcome
        return outcome
