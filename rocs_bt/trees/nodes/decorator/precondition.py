"""Precondition: a script decides whether the child is ticked."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.common import Status

from ...script import compile_condition, parse_script
from ...status import IDLE, RUNNING, SKIPPED, Outcome
from ..family import Decorator
from ..port import Code, Input


class Precondition(Decorator):
    """Ticks the child once the script `if` holds, until the child has ended; comes to `else` while it does not hold.

    The script is not asked again while the child is under way.
    """

    script = Code(doc="the script", name="if")
    otherwise = Input(Status, "FAILURE", "what it comes to while the script does not hold", name="else")

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._under_way = False
        self._compiled: tuple[str, Callable[[], bool]] | None = None

    def bind(self, board: Any, runtime: Any) -> Any:
        self._compiled = None
        return super().bind(board, runtime)

    def tick_once(self) -> Outcome:
        outcome: Outcome
        if self._under_way or self._holds():
            self._under_way = True
            outcome = self.tick_child()
            if outcome is not RUNNING and outcome is not SKIPPED:
                self._under_way = False
        else:
            outcome = self.otherwise
        if outcome is not SKIPPED:
            self.status = outcome
        elif self.status is not RUNNING:
            self.status = IDLE
        return outcome

    def _holds(self) -> bool:
        text = self.script
        if self._compiled is None or self._compiled[0] != text:
            self._compiled = text, compile_condition(parse_script(text), self.board)
        return self._compiled[1]()
