"""Blackboard: values shared by the nodes of one tree.

A subtree has its own blackboard. Keys of this blackboard can refer to keys of the parent tree's blackboard.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from ..base.errors import Fault, InputError, did_you_mean
from .error import TreeError
from .value import Enums, converted, plain, to_string, type_name

Parse = Callable[[str, Enums], Any]
"""Converter from a text to a value; the names of enum values may be used."""


class BoardEntry:
    """Value of one blackboard key, with the type of the key.

    Attributes:
        value: The value; None if there is none.
        kind: Type fixed by a port or by the first write that has a type; None if any value is allowed.
        declared: Whether a port declared the type. If only a value fixed it, a port can still declare another type.
        parse: Converter of texts of the port that declared the type, such as one for quantities; None for the usual.
        written: Text of a literal that was converted to a number; valid until the next write. See `text`.
        sequence: Number of writes, by which nodes detect a new value.
        alive: Whether the entry is still on its blackboard. If it is not, because the key was unset, code that holds a
            reference to the entry must look up the key again.
    """

    __slots__ = ("alive", "declared", "kind", "parse", "sequence", "value", "written")

    def __init__(self, kind: Any = None) -> None:
        self.value: Any = None
        self.kind = kind
        self.declared = kind is not None
        self.parse: Parse | None = None
        self.written: str | None = None
        self.sequence = 0
        self.alive = True

    def store(self, value: Any) -> None:
        """Write a value; the caller has checked its type."""
        self.value = value
        self.sequence += 1

    @property
    def text(self) -> str | None:
        """Text of the literal that the value is, as written in the file; None if the value is not a literal."""
        return self.written if self.sequence == 1 else None


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
        self._entries: dict[str, BoardEntry] = {}

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

    def entry(self, key: str) -> BoardEntry | None:
        """Entry of a key in this blackboard or an ancestor; None if there is none."""
        found = self._entries.get(key)
        if found is not None:
            return found
        board, name = self.resolve(key)
        return board._entries.get(name)

    def declare(self, key: str, kind: Any = None, parse: Parse | None = None) -> BoardEntry:
        """Return the entry of a key, created if it does not exist.

        Args:
            key: The key.
            kind: Type of a new entry; None or Any for any value.
            parse: Converter of texts that are written to the entry, if the type has no usual one or the port another.

        Raises:
            TreeError: The key was declared with another type, or its value does not fit the type. An existing text is
                allowed, because it is converted when it is read.
        """
        board, name = self.resolve(key)
        kind = None if kind is Any else kind
        entry = board._entries.get(name)
        if entry is None:
            entry = board._entries[name] = BoardEntry(kind)
        elif kind is not None and not entry.declared and entry.kind is not None:
            before, entry.kind = entry.kind, kind
            try:
                if entry.value is not None and entry.value.__class__ is not str:
                    entry.value = self.fitted(key, entry, entry.value)
            except TreeError:
                entry.kind = before
                raise
            entry.declared = True
        elif kind is not None and entry.kind not in (None, str, kind):
            hint = "The first declaration of a key fixes its type; use another key."
            message = f"the key '{key}' is of type {type_name(entry.kind)}, not {type_name(kind)}."
            raise TreeError(Fault(message, hint=hint))
        if parse is not None:
            entry.parse = parse
        return entry

    def set_local(self, key: str, value: Any, written: str | None = None) -> None:
        """Write a value to this blackboard itself: remappings are ignored, and the key's type is not fixed.

        Args:
            key: The key.
            value: The value.
            written: Text of the value in the file, which ports for text read; None if the value is no literal.
        """
        entry = self._entries.setdefault(key, BoardEntry())
        entry.store(value)
        entry.written = written

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
        kind, entry = type(value), self.entry(key)
        if entry is None or entry.kind is None:
            value = plain(value)
            kind = type(value)
        if entry is None:
            board, name = self.resolve(key)
            entry = board._entries[name] = BoardEntry()
            entry.kind = None if kind is str else kind
            entry.store(value)
        elif entry.kind is None:
            entry.kind = kind
            entry.store(value)
        else:
            entry.store(self.fitted(key, entry, value))

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

    def entries(self) -> Iterator[tuple[str, BoardEntry]]:
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

    def fitted(self, key: str, entry: BoardEntry, value: Any) -> Any:
        """Convert a value to the type of the entry to which it is written.

        Args:
            key: Key, for messages.
            entry: Entry of the key, which has a type.
            value: Value to write.

        Raises:
            TreeError: The value cannot be converted to the type. A number is not converted to a text, because the key
                may be a text only because a text was written first.
        """
        kind = entry.kind
        try:
            if entry.parse is not None and isinstance(value, str):
                return entry.parse(value, self.enums)
            if kind is not str or isinstance(value, str):
                return converted(value, kind, self.enums)
        except InputError as error:
            if isinstance(value, str):
                raise TreeError(*(Fault(f"the key '{key}': {f.message}", hint=f.hint) for f in error.faults)) from error
        hint = "The first write of a key fixes its type; use another key."
        message = f"the key '{key}' is of type {type_name(kind)}, and {value!r} does not fit."
        raise TreeError(Fault(message, hint=hint))
