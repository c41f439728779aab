"""Decorators that wait for a key to be written."""

from __future__ import annotations

from typing import Any, ClassVar

from ...status import IDLE, RUNNING, SKIPPED, Outcome
from ..family import Decorator
from ..port import Input


class _Updated(Decorator):
    """Ticks the child if the key was written since this was ticked last, and while the child is RUNNING."""

    otherwise: ClassVar[Outcome] = SKIPPED
    entry = Input(object, doc="the key")

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._seen = 0

    def tick_once(self) -> Outcome:
        outcome = self.tick_child() if self.decorated.status is RUNNING or self._written() else self.otherwise
        if outcome is not SKIPPED:
            self.status = outcome
        elif self.status is not RUNNING:
            self.status = IDLE
        return outcome

    def _written(self) -> bool:
        entry = self.board.entry(self.key("entry") or str(self.given["entry"]))
        before, self._seen = self._seen, 0 if entry is None else entry.sequence
        return entry is not None and before != self._seen


class SkipUnlessUpdated(_Updated):
    """Skipped while the key `entry` was not written since it was ticked last."""

    otherwise = SKIPPED


class WaitValueUpdate(_Updated):
    """RUNNING while the key `entry` was not written since it was ticked last."""

    otherwise = RUNNING
