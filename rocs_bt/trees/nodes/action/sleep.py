"""Sleep: lets time pass."""

from __future__ import annotations

from typing import Any

from ...status import RUNNING, SUCCESS, Outcome
from ..decorator.timing import FORGIVEN
from ..family import Leaf
from ..port import Input


class Sleep(Leaf):
    """RUNNING for `msec` milliseconds of the tree's clock, then SUCCESS."""

    msec = Input(int, doc="how long [ms]")

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self._until = 0.0

    def initialise(self) -> None:
        milliseconds = self.msec
        self._until = self.runtime.now() + milliseconds / 1000.0 if milliseconds > 0 else 0.0

    def update(self) -> Outcome:
        return SUCCESS if not self._until or self.runtime.now() >= self._until - FORGIVEN else RUNNING
