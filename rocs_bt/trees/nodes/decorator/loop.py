"""Loops over a queue, which may be a list on the board, or text such as `1;2;3`."""

from __future__ import annotations

from collections.abc import Sequence as Many
from typing import Any, ClassVar

from py_trees.common import Status

from ....errors import Fault
from ...board import from_string
from ...error import TreeError
from ...status import FAILURE, IDLE, RUNNING, SKIPPED, Outcome
from ..family import Decorator
from ..port import InOut, Input, Output


class _Loop(Decorator):
    """Takes an item off the queue, writes it to `value` and ticks the child, once a tick; `if_empty` when none is left.

    RUNNING while there are items, FAILURE as soon as the child fails. A list on the board is emptied in place; a text
    is a new queue in each run.
    """

    item: ClassVar[Any] = str
    queue = InOut(object, None, "the items")
    if_empty = Input(Status, "SUCCESS", "what it comes to when the queue is empty")

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._items: list[Any] | None = None
        self._source: object = None
        self._under_way = False

    def halted(self) -> None:
        self._under_way = False
        super().halted()

    def tick_once(self) -> Outcome:
        if self.status is not RUNNING:
            self._under_way = False
            if self.key("queue") is None:
                self._source = None
        if not self._under_way:
            items = self._queue()
            if not items:
                return self._told(self.if_empty)
            self.write("value", items.pop(0))
        self.status = RUNNING
        outcome = self.tick_child()
        self._under_way = outcome is RUNNING
        return self._told(FAILURE if outcome is FAILURE else RUNNING)

    def _told(self, outcome: Outcome) -> Outcome:
        if outcome is not SKIPPED:
            self.status = outcome
        elif self.status is not RUNNING:
            self.status = IDLE
        return outcome

    def _queue(self) -> list[Any]:
        source = self.queue
        if isinstance(source, list):
            return source
        if self._items is None or source != self._source:
            self._items, self._source = self._converted(source), source
        return self._items

    def _converted(self, source: Any) -> list[Any]:
        if source is None:
            return []
        if isinstance(source, str):
            kind = list[self.item]  # type: ignore[name-defined]  # the items' type is known at run time only
            found: list[Any] = from_string(source, kind, self.board.enums)
            return found
        if isinstance(source, Many):
            return list(source)
        raise TreeError(Fault(f"the queue of '{self.name}' must be a list or a text, found {source!r}."))


class LoopString(_Loop):
    """A loop over texts."""

    __doc__ = f"A loop over texts. {_Loop.__doc__}"
    item = str
    value = Output(str, "the present item")


class LoopInt(_Loop):
    """A loop over whole numbers."""

    __doc__ = f"A loop over whole numbers. {_Loop.__doc__}"
    item = int
    value = Output(int, "the present item")


class LoopDouble(_Loop):
    """A loop over numbers."""

    __doc__ = f"A loop over numbers. {_Loop.__doc__}"
    item = float
    value = Output(float, "the present item")


class LoopBool(_Loop):
    """A loop over truths."""

    __doc__ = f"A loop over truths. {_Loop.__doc__}"
    item = bool
    value = Output(bool, "the present item")
