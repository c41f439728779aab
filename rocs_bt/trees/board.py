"""Blackboard: values shared by the nodes of one tree.

A subtree has its own blackboard. Keys of this blackboard can refer to keys of the parent tree's blackboard.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from enum import Enum
from typing import Any, get_args, get_origin

from py_trees.common import Status

from ..errors import Fault, did_you_mean
from .error import TreeError
from .status import outcome_named


class Entry:
    """Value of one blackboard key, with the type of the key.

    Attributes:
        value: The value; None if there is none.
        kind: Type fixed by a port or by the first write that has a type; None if any value is allowed.
        sequence: Number of writes, by which nodes detect a new value.
        alive: Whether the entry is still on its blackboard. If it is not, because the key was unset, code that holds a
            reference to the entry must look up the key again.
    """

    __slots__ = ("alive", "kind", "sequence", "value")

    def __init__(self, kind: Any = None) -> None:
        self.value: Any = None
        self.kind = kind
        self.sequence = 0
        self.alive = True

    def store(self, value: Any) -> None:
        """Write a value; the caller has checked its type."""
        self.value = value
        self.sequence += 1


_INTEGER = re.compile(r"-?\d+")
_REAL = re.compile(r"-?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|inf|nan)")
_TRUTH = {
    "1": True,
    "true": True,
    "TRUE": True,
    "True": True,
    "0": False,
    "false": False,
    "FALSE": False,
    "False": False,
}

Enums = Mapping[str, int]
"""Enum values, keyed by the names that scripts and ports may use for them."""


def from_string(text: str, kind: Any, enums: Enums | None = None) -> Any:
    """Convert text to the type of a port.

    Args:
        text: Text as in a file; items of a list are separated by `;`.
        kind: bool, int, float, str, Status, an Enum, `list[...]` of them, or Any, which leaves the text unchanged.
        enums: Numbers by name; int, float and Enum ports also accept these names.

    Raises:
        TreeError: The text cannot be converted.
    """
    enums = enums or {}
    if kind is Any or kind is str:
        return text
    if kind is bool:
        return _looked_up(text, _TRUTH, "true or false")
    if kind is int:
        return enums[text] if text in enums else int(_matched(text, _INTEGER, "a whole number"))
    if kind is float:
        return float(enums[text]) if text in enums else float(_matched(text, _REAL, "a number"))
    if get_origin(kind) is list:
        (item,) = get_args(kind)
        return [from_string(part, item, enums) for part in text.split(";")] if text else []
    if kind is Status:
        return outcome_named(text)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return _member(text, kind, enums)
    raise TreeError(
        Fault(f"{text!r} cannot be converted to {kind}: only the blackboard holds such values, never a file.")
    )


def to_string(value: Any) -> str:
    """Text of a value as BehaviorTree.CPP writes it: integers as usual, other numbers with six decimals."""
    if isinstance(value, bool):
        return str(int(value))
    return f"{value:.6f}" if isinstance(value, float) else str(value)


def _member(text: str, kind: type[Enum], enums: Enums) -> Any:
    if text in kind.__members__:
        return kind[text]
    number = enums.get(text, int(text) if _INTEGER.fullmatch(text) else None)
    for member in kind:
        if member.value == number and number is not None:
            return member
    return _looked_up(text, kind.__members__, f"one of {', '.join(kind.__members__)}")


def _matched(text: str, pattern: re.Pattern[str], what: str) -> str:
    if not pattern.fullmatch(text):
        raise TreeError(Fault(f"{text!r} is not {what}."))
    return text


def _looked_up(text: str, table: Mapping[str, Any], what: str) -> Any:
    if text not in table:
        raise TreeError(Fault(f"{text!r} is not {what}."))
    return table[text]


class Board:
    """Blackboard: values by key, with the semantics of BehaviorTree.CPP's blackboard.

    A key is looked up on this blackboard first. If it is missing here and is remapped, or if `autoremap` is on, it is
    looked up on the parent blackboard, under its remapped name. Keys that begin with `_` are private: `autoremap` does
    not apply to them. `@key` is always the key `key` of the root blackboard.

    Args:
        parent: Blackboard of the tree that contains this subtree; None for a root.
        autoremap: Whether keys that are missing here refer to the parent's keys of the same name.
        name: Name for messages, such as the path of a subtree.

    Attributes:
        remapping: Keys of the parent to which remapped keys of this blackboard refer, by remapped key.
        enums: Enum values by name, used in conversions; shared by all blackboards of a tree.
    """

    def __init__(self, parent: Board | None = None, *, autoremap: bool = False, name: str = "") -> None:
        self.parent = parent
        self.autoremap = autoremap
        self.name = name
        self.remapping: dict[str, str] = {}
        self.enums: Enums = parent.enums if parent else {}
        self._entries: dict[str, Entry] = {}

    @property
    def root(self) -> Board:
        """Blackboard at the end of the chain of parents."""
        board = self
        while board.parent is not None:
            board = board.parent
        return board

    def resolve(self, key: str) -> tuple[Board, str]:
        """Find the blackboard that holds a key, or would hold it once written, and the key's name on it."""
        if key.startswith("@"):
            if "@" in key[1:]:
                raise TreeError(Fault(f"the key '{key}' contains more than one '@'."))
            return self.root, key[1:]
        board = self
        while board.parent is not None and key not in board._entries:
            if key in board.remapping:
                key = board.remapping[key]
                if key.startswith("@"):
                    return board.root, key[1:]
            elif not board.autoremap or key.startswith("_"):
                break
            board = board.parent
        return board, key

    def entry(self, key: str) -> Entry | None:
        """Entry of a key in this blackboard or an ancestor; None if there is none."""
        found = self._entries.get(key)
        if found is not None:
            return found
        board, name = self.resolve(key)
        return board._entries.get(name)

    def declare(self, key: str, kind: Any = None) -> Entry:
        """Return the entry of a key, created if it does not exist.

        Args:
            key: The key.
            kind: Type of a new entry; None or Any for any value.

        Raises:
            TreeError: The key exists with another type. An existing text is allowed, because it is converted when it is
                read.
        """
        board, name = self.resolve(key)
        kind = None if kind is Any else kind
        entry = board._entries.get(name)
        if entry is None:
            entry = board._entries[name] = Entry(kind)
        elif kind is not None and entry.kind not in (None, str, kind):
            hint = "The first declaration of a key fixes its type; use another key."
            message = f"the key '{key}' is of type {type_name(entry.kind)}, not {type_name(kind)}."
            raise TreeError(Fault(message, hint=hint))
        return entry

    def set_local(self, key: str, value: Any) -> None:
        """Write a value to this blackboard itself: remappings are ignored, and the key's type is not fixed."""
        self._entries.setdefault(key, Entry()).store(value)

    def __getitem__(self, key: str) -> Any:
        """Value of a key.

        Raises:
            TreeError: The key has no value.
        """
        entry = self.entry(key)
        if entry is None or entry.value is None:
            raise TreeError(Fault(f"the board has no value at '{key}'.", hint=did_you_mean(key, self.keys(), "It")))
        return entry.value

    def __setitem__(self, key: str, value: Any) -> None:
        """Write a value. The first value fixes the key's type, unless it is a text: then the second value does.

        Raises:
            TreeError: The value does not fit the entry's type.
        """
        kind = type(value)
        entry = self.entry(key)
        if entry is None:
            entry = self.declare(key, None if kind is str else kind)
            entry.store(value)
        elif entry.kind is None:
            entry.kind = kind
            entry.store(value)
        else:
            entry.store(self.fitted(key, entry.kind, value))

    def __contains__(self, key: object) -> bool:
        return isinstance(key, str) and (entry := self.entry(key)) is not None and entry.value is not None

    def unset(self, key: str) -> None:
        """Remove a key of this blackboard. As in BehaviorTree.CPP, remappings are ignored: the parents' keys remain."""
        board, name = (self.root, key[1:]) if key.startswith("@") else (self, key)
        entry = board._entries.pop(name, None)
        if entry is not None:
            entry.alive = False

    def keys(self) -> list[str]:
        """Sorted keys of this blackboard that have a value."""
        return sorted(key for key, entry in self._entries.items() if entry.value is not None)

    def entries(self) -> Iterator[tuple[str, Entry]]:
        """Entries of this blackboard in the order of creation."""
        yield from self._entries.items()

    def texts(self) -> dict[str, str]:
        """Scalar values of this blackboard, as text in BehaviorTree.CPP's format."""
        found = ((key, entry.value) for key, entry in sorted(self._entries.items()))
        return {key: to_string(value) for key, value in found if isinstance(value, (int, float, str))}

    def update(self, values: Mapping[str, Any]) -> None:
        """Write several values."""
        for key, value in values.items():
            self[key] = value

    def fitted(self, key: str, kind: Any, value: Any) -> Any:
        """Convert a value to the type of an entry or port: text is parsed, numbers are converted if nothing is lost.

        Raises:
            TreeError: The value cannot be converted to the type.
        """
        given = type(value)
        if given is kind:
            return value
        if given is str:
            return from_string(value, kind, self.enums)
        if kind is float and given in (int, bool):
            return float(value)
        if kind is int and (given is bool or (given is float and value.is_integer())):
            return int(value)
        if isinstance(kind, type) and isinstance(value, kind) and kind not in (int, float):
            return value
        if isinstance(value, list) and type_name(kind).startswith("list"):
            return value
        hint = "The first write of a key fixes its type; use another key."
        message = f"the key '{key}' is of type {type_name(kind)}, and {value!r} does not fit."
        raise TreeError(Fault(message, hint=hint))


def type_name(kind: Any) -> str:
    """Name of a type in messages."""
    return kind.__name__ if isinstance(kind, type) and not hasattr(kind, "__args__") else str(kind)
