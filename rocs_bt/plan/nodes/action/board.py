"""Leaves that write, remove and watch keys of the board."""

from __future__ import annotations

from typing import Any

from ....errors import Fault
from ...board import from_string
from ...error import TreeError
from ...status import FAILURE, SUCCESS, Outcome
from ..family import Instant
from ..port import InOut, Input


class SetBlackboard(Instant):
    """Writes a text, or the value of another key with its type, to a key; FAILURE if that other key has no value."""

    value = Input(object, doc="a text, or a key such as {source}")
    output_key = InOut(str, doc="the name of the key that is written, with or without braces")

    def update(self) -> Outcome:
        key, board = self._target(), self.board
        source = self.key("value")
        target = board.entry(key)
        if source is None:
            value: Any = self.given["value"]
        else:
            entry = board.entry(source)
            if entry is None:
                raise TreeError(Fault(f"'{self.name}' copies the key '{source}', which does not exist."))
            target = target or board.declare(key, entry.kind)
            value = entry.value
            if value is None:
                return FAILURE
        if target is not None and isinstance(value, str) and target.kind not in (None, str):
            value = from_string(value, target.kind, board.enums)
        if target is not None and target.kind is None:
            target.store(value)  # a copy fixes no type
        else:
            board[key] = value
        return SUCCESS

    def _target(self) -> str:
        given: str = self.given["output_key"]
        key = self.key("output_key")
        if key is None:
            return given
        entry = self.board.entry(key)
        # The braces ask for the name that the key holds; most people mean the key itself, as older versions did.
        return entry.value if entry is not None and isinstance(entry.value, str) else key


class UnsetBlackboard(Instant):
    """Removes a key of its own board; SUCCESS."""

    key_ = Input(str, doc="the key, without braces", name="key")

    def update(self) -> Outcome:
        self.board.unset(self.read("key"))
        return SUCCESS


class WasEntryUpdated(Instant):
    """SUCCESS if the key was written since this was ticked last, FAILURE if it was not."""

    kind = "Action"
    entry = Input(object, doc="the key")

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self._seen = 0

    def update(self) -> Outcome:
        entry = self.board.entry(self.key("entry") or str(self.given["entry"]))
        before, self._seen = self._seen, 0 if entry is None else entry.sequence
        return SUCCESS if entry is not None and before != self._seen else FAILURE
