"""TOML documents with positions: reading a document collects all faults, each with file, line and column.

`rocs_bt.declare` reads the tables. Keys that no reader knows are reported as unknown.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, NamedTuple

from .errors import Fault, InputError, did_you_mean
from .files import is_file, read_text
from .toml_text import Key, parse_toml

_OBSERVED: ContextVar[list[Table] | None] = ContextVar("observed", default=None)


@contextmanager
def observed_tables() -> Iterator[list[Table]]:
    """Context that lists the tables that are read in it, by this thread, with the keys that their readers know."""
    tables: list[Table] = []
    token = _OBSERVED.set(tables)
    try:
        yield tables
    finally:
        _OBSERVED.reset(token)


class KnownKey(NamedTuple):
    """Key for which a reader has asked.

    Attributes:
        kind: Kind of the value, such as `a text` or `a quantity [m]`; empty if the reader takes any value.
        options: Valid values; empty if there are others.
        default: Value without the key, as a file has it; None if there is none to name.
        required: Whether the key must be given.
        doc: Description.
    """

    kind: str = ""
    options: tuple[str, ...] = ()
    default: Any = None
    required: bool = False
    doc: str = ""


class Table:
    """Table of a TOML document. All tables of a document share one list of faults.

    Attributes:
        file: Path of the document's file.
        key: Key of this table, as the path from the root of the document.
        faults: Faults found so far in the whole document.
        bases: Files on which the document is based (`base = ...`), nearest first.
        data: Content of the table, as parsed by tomllib.
        positions: Line and column of each key in the document.
        known: Keys for which a reader has asked, by name.
    """

    def __init__(
        self,
        file: Path,
        data: dict[str, Any],
        key: Key,
        positions: dict[Key, tuple[int, int]],
        bases: tuple[Path, ...] = (),
    ) -> None:
        self.file = file
        self.key = key
        self.faults: list[Fault] = []
        self.bases = bases
        self.data = data
        self.positions = positions
        self.known: dict[str, KnownKey] = {}
        self._children: list[Table] = []
        if (tables := _OBSERVED.get()) is not None:
            tables.append(self)

    def __contains__(self, key: str) -> bool:
        return key in self.data

    @property
    def label(self) -> str:
        """Name of this table for messages."""
        return ".".join(str(k) for k in self.key) or "the file"

    def position(self, key: str | None = None) -> tuple[int, int]:
        """Line and column of a key of this table, or of the table itself; 0 if unknown."""
        return self.position_of(self.key if key is None else (*self.key, key))

    def position_of(self, path: Key) -> tuple[int, int]:
        """Line and column of a full key, or of the innermost table around it with a known position; 0 if unknown."""
        if path and path not in self.positions:
            # A table may be implicit, as `a` is in the header [a.b].
            inner = next((k for k in self.positions if k[: len(path)] == path), None)
            path = path if inner is None else inner
        while path and path not in self.positions:
            path = path[:-1]
        return self.positions.get(path, (0, 0))

    def beside(self, name: str) -> Path:
        """Path of a file in the folder of the document, or else in the folder of one of its bases."""
        found = [file.parent / name for file in (self.file, *self.bases)]
        return next((path for path in found if is_file(path)), found[0])

    def fault(self, key: str | None, message: str, hint: str = "", warning: bool = False) -> None:
        """Record a fault at a key of this table, or at the table itself if `key` is None."""
        line, column = self.position(key)
        self.faults.append(Fault(message, self.file, line, column, hint, warning))

    def adopt(self, key: str | None, error: InputError) -> None:
        """Record the faults of an error that other code raised about the value of a key."""
        self.faults.extend(error.at(self.file, *self.position(key)).faults)

    def done(self) -> None:
        """Finish reading: record a fault for each key that was not read, here and in the sub-tables that were read.

        Raises:
            InputError: The document has faults other than warnings.
        """
        self._note_unknown_keys()
        if any(not f.warning for f in self.faults):
            raise InputError(*(f for f in self.faults if not f.warning))

    def _note_unknown_keys(self) -> None:
        for key in self.data:
            if key not in self.known:
                self.fault(key, f"unknown key '{key}' in {self.label}.", hint=did_you_mean(key, self.known))
        for child in self._children:
            child._note_unknown_keys()

    def child(self, data: dict[str, Any], *key: str | int) -> Table:
        """Table within this one, with the path that leads to it; shares the faults."""
        child = Table(self.file, data, (*self.key, *key), self.positions, self.bases)
        child.faults = self.faults
        self._children.append(child)
        return child


def read_toml(file: Path, text: str | None = None) -> Table:
    """Read the root table of a TOML file.

    Raises:
        InputError: The file cannot be read, is not UTF-8, or is not valid TOML; with the position of the fault.
    """
    data, positions = parse_toml(read_text(file) if text is None else text, file)
    return Table(file, data, (), positions)
