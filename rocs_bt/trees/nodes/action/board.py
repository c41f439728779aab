"""Leaves that write, remove and watch keys of the board."""

from __future__ import annotations

from typing import Any

from ....errors import Fault
from ...error import TreeError
from ...status import FAILURE, SUCCESS, Outcome
from ..family import Instant
from ..port import InOut, Input


class SetBlackboard(Instant):
    """Writes a text, or the value of another key with its type, to a key; FAILURE if that other key has no value."""

    value = Input(object, doc="a text, or a key such as {source}")
    output_key = InOut(str, doc="the name of the key that is written, with or without braces")

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self._source = self.key("value")
        self._key = self.key("output_key")
        self._number: tuple[Any, Any, Any] = None, None, None

    def update(self) -> Outcome:
        board, key = self.board, self._key
        if key is None:
            key = self.given["output_key"]
        else:
            named = board.entry(key)
            # The braces ask for the name that the key holds; most people mean the key itself, as older versions did.
            if named is not None and named.value.__class__ is str:
                key = named.value
        target = board.entry(key)
        if self._source is None:
            value: Any = self.given["value"]
        else:
            entry = board.entry(self._source)
            if entry is None:
                raise TreeError(Fault(f"'{self.name}' copies the key '{self._source}', which does not exist."))
            target = target or board.declare(key, entry.kind)
            value = entry.value
            if value is None:
                return FAILURE
        if target is None:
            board[key] = value
        elif target.kind is None or target.kind is value.__class__:
            target.store(value)  # a copy fixes no type
        elif self._source is None and target.kind in (bool, int, float):
            target.store(self._as_number(key, target.kind, value))
        else:
            target.store(board.fitted(key, target.kind, value))
        return SUCCESS

    def _as_number(self, key: str, kind: Any, value: Any) -> Any:
        """The literal as a number, converted when it is first needed."""
        enums = self.board.enums
        if self._number[0] is not kind or self._number[1] is not enums:
            self._number = kind, enums, self.board.fitted(key, kind, value)
        return self._number[2]


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
