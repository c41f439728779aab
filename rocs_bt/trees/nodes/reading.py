"""Reading: how a port's key is read, tick after tick."""

from __future__ import annotations

from typing import Any

from ...errors import Fault
from ..board import Board, to_string
from ..error import TreeError
from .port import Port


class Reading:
    """Reads a port's key: once found, the entry is asked directly.

    Args:
        port: The port.
        owner: Tag and name of the node that it is of, for messages.
        board: Where the key lives.
        key: The key it points at.
    """

    __slots__ = ("_board", "_entry", "_key", "_kind", "_owner", "_port")

    def __init__(self, port: Port[Any], owner: tuple[str, str], board: Board, key: str) -> None:
        self._port, self._owner, self._board, self._key = port, owner, board, key
        self._kind, self._entry = port.kind, board.entry(key)

    def __call__(self) -> Any:
        entry = self._entry
        if entry is None or not entry.alive:
            entry = self._entry = self._board.entry(self._key)
        if entry is None or entry.value is None:
            if self._port.default is None:
                return None
            tag, name = self._owner
            where = f"'{self._port.name}' of {tag} '{name}'"
            raise TreeError(Fault(f"{where} reads the key '{self._key}', which has no value."))
        value, kind = entry.value, self._kind
        if kind is Any or value.__class__ is kind:
            return value
        if value.__class__ is str:
            return self._port.value(value, self._board.enums)
        if kind is str and isinstance(value, (int, float)):
            return to_string(value)  # a subtree's literal such as a="1" is a number on its board
        return self._board.fitted(self._key, kind, value)
