"""TryCatch: a sequence, and what is done when it fails (BehaviorTree.CPP 4.9 and later)."""

from __future__ import annotations

from typing import Any

from ...status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ..family import Control, halt
from ..port import Input


class TryCatch(Control):
    """Ticks all children but the last as a Sequence; if one fails, the last is ticked till it ends: FAILURE."""

    least = 2
    catch_on_halt = Input(bool, False, "whether the last child is ticked, once, when the others are halted")

    def __init__(self, name: str, children: Any = (), /, **attributes: Any) -> None:
        super().__init__(name, children, **attributes)
        self._catching = False

    def tick_once(self) -> Outcome:
        if self.status is not RUNNING:
            self._skipped = 0
            self._catching = False
            self.status = RUNNING
        children = self.children
        last = len(children) - 1
        while not self._catching and self._index < last:
            outcome = self._tick(self._index)
            if outcome is RUNNING:
                return outcome
            if outcome is FAILURE:
                self.halt_children()
                self._catching = True
            else:
                self._skipped += outcome is SKIPPED
                self._index += 1
        if not self._catching:
            return self._finish(SKIPPED if self._skipped == last else SUCCESS)
        return RUNNING if self._tick(last) is RUNNING else self._finish(FAILURE)

    def halted(self) -> None:
        if self.catch_on_halt and not self._catching:
            for child in self.children[:-1]:
                halt(child)
            self._tick(len(self.children) - 1)
        super().halted()
        self._catching = False

    def _tick(self, index: int) -> Outcome:
        child: Any = self.children[index]
        outcome: Outcome = child.tick_once() or child.status
        if outcome is IDLE:
            raise self.strange(child, outcome)
        self.current_child = child
        return outcome

    def _finish(self, outcome: Outcome) -> Outcome:
        self.halt_children()
        self._index = self._skipped = 0
        self._catching = False
        if outcome is not SKIPPED:
            self.status = outcome
        return outcome
