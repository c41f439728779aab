"""Reading: how a port's key is read, tick after tick."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ...errors import Fault
from ..board import to_string
from ..error import TreeError
from .port import Port

if TYPE_CHECKING:
    from .node import Node


class Reading:
    """Reads a port's key: once found, the entry is asked directly.

    Args:
        node: Whose port.
        port: The port.
        key: The key it points at.
    """

    __slots__ = ("_board", "_entry", "_key", "_kind", "_node", "_port")

    def __init__(self, node: Node, port: Port[Any], key: str) -> None:
        self._node, self._port, self._key = node, port, key
        self._board, self._kind, self._entry = node.board, port.kind, node.board.entry(key)

    def __call__(self) -> Any:
        entry = self._entry
        if entry is None or not entry.alive:
            entry = self._entry = self._board.entry(self._key)
        if entry is None or entry.value is None:
            if self._port.default is None:
                return None
            where = f"'{self._port.name}' of {self._node.tag} '{self._node.name}'"
            raise TreeError(Fault(f"{where} reads the key '{self._key}', which has no value."))
        value, kind = entry.value, self._kind
        if kind is Any or value.__class__ is kind:
            return value
        if value.__class__ is str:
            return self._port.value(value, self._board.enums)
        if kind is str and isinstance(value, (int, float)):
            return to_string(value)  # a subtree's literal such as a="1" is a number on its board
        return self._board.fitted(self._key, kind, value)
