"""TOML documents with positions: reading a document collects all faults, each with file, line and column.

A `Table` is read key by key. Keys that were never read are reported as unknown.

    table = read_toml(path)
    name = table.text("name")
    rate = table.quantity("rate", FREQUENCY, default=20.0)
    table.done()            # raises InputError with all faults
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, NamedTuple

from .errors import Fault, InputError, did_you_mean
from .files import is_file, read_text
from .toml_text import Key, parse_toml
from .units import Dimension, convert

_MISSING = object()
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
        default: Value without the key; None if there is none, or if the key is required.
        required: Whether the key must be given.
    """

    kind: str = ""
    options: tuple[str, ...] = ()
    default: Any = None
    required: bool = False


class Table:
    """Table of a TOML document, which is read key by key.

    If a value is missing or invalid, a fault is recorded, and a harmless value of the right type is returned, so that
    reading can continue and find further faults. All tables of a document share one list of faults.

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

    def raw(self, key: str, default: Any = _MISSING) -> Any:
        """Read a value without conversion; if it is missing and has no default, record a fault and return None."""
        self._ask(key, "", default)
        if key in self.data:
            return self.data[key]
        if default is _MISSING:
            self.fault(None, f"{self.label} has no '{key}'.", hint=f"Add a line '{key} = ...'.")
            return None
        return default

    def text(self, key: str, default: Any = _MISSING) -> str:
        """Read a string."""
        value: str = self._typed(key, str, "a text", default, "")
        return value

    def choice(self, key: str, options: Collection[str], default: Any = _MISSING) -> str:
        """Read a string that must be one of `options`."""
        value = self.text(key, default)
        self.known[key] = self.known[key]._replace(options=tuple(options))
        if value not in options and (key in self.data and isinstance(self.data[key], str)):
            hint = did_you_mean(value, options, "Valid values:")
            self.fault(key, f"invalid value '{value}' for '{key}'.", hint=hint)
        return value

    def flag(self, key: str, default: Any = _MISSING) -> bool:
        """Read a boolean."""
        return bool(self._typed(key, bool, "true or false", default, False))

    def integer(self, key: str, default: Any = _MISSING, low: int | None = None, high: int | None = None) -> int:
        """Read an integer of at least `low` and at most `high`."""
        value = int(self._typed(key, int, "a whole number", default, low or 0))
        if key not in self.data:
            return value
        if low is not None and value < low:
            self.fault(key, f"{key} must be at least {low}, found {value}.")
            return low
        if high is not None and value > high:
            self.fault(key, f"{key} must be at most {high}, found {value}.")
            return high
        return value

    def texts(self, key: str, default: Any = _MISSING) -> list[str]:
        """Read a list of strings."""
        values = self._typed(key, list, "a list of texts", default, [])
        if any(not isinstance(v, str) for v in values):
            self.fault(key, f"{key} must be a list of texts, found {values!r}.")
            return []
        return list(values)

    def quantity(
        self,
        key: str,
        dimension: Dimension,
        default: Any = _MISSING,
        low: float | None = None,
        high: float | None = None,
    ) -> float:
        """Read a number with its unit, in SI units.

        Args:
            key: Key of the number.
            dimension: Expected dimension.
            default: Value if the key is missing [SI].
            low: Minimum [SI].
            high: Maximum [SI]; None for any finite value.
        """
        self._ask(key, f"a quantity{_in_unit(dimension)}", default)
        value = self.raw(key, default)
        if key not in self.data:
            return (low or 0.0) if value is None else value
        return self._quantity(key, value, dimension, low, high)

    def table(self, key: str, optional: bool = True) -> Table:
        """Read a sub-table; an empty one if it is missing."""
        data = self._typed(key, dict, "a table", {} if optional else _MISSING, {})
        return self.child(data, key)

    def tables(self, key: str) -> list[Table]:
        """Read an array of tables `[[key]]`; empty if it is missing."""
        values = self._typed(key, list, "a list of tables", [], [])
        if any(not isinstance(v, dict) for v in values):
            self.fault(key, f"{key} must be written as [[{key}]] tables.")
            return []
        return [self.child(v, key, i) for i, v in enumerate(values)]

    def named_tables(self, key: str) -> dict[str, Table]:
        """Read the tables `[key.NAME]`, by name; empty if there are none."""
        values = self._typed(key, dict, "a table of tables", {}, {})
        if bad := [name for name, v in values.items() if not isinstance(v, dict)]:
            self.fault(key, f"{key}.{bad[0]} must be a table.", hint=f"Write it as [{key}.{bad[0]}].")
        return {n: self.child(v, key, n) for n, v in values.items() if isinstance(v, dict)}

    def keys(self) -> list[str]:
        """Keys in this table, for tables with keys that the user chooses."""
        return list(self.data)

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

    def _ask(self, key: str, kind: str, default: Any) -> None:
        """Note that a reader knows a key; the first note that has a kind stays."""
        if key not in self.known or (kind and not self.known[key].kind):
            required = default is _MISSING
            self.known[key] = KnownKey(kind, (), None if required else default, required)

    def _typed(self, key: str, kind: type, words: str, default: Any, harmless: Any) -> Any:
        self._ask(key, words, default)
        value = self.raw(key, default)
        if key not in self.data:
            return harmless if value is None and default is _MISSING else value
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            self.fault(key, f"{key} must be {words}, found {value!r}.")
            return harmless
        return value

    def _quantity(self, key: str, value: Any, dimension: Dimension, low: float | None, high: float | None) -> float:
        try:
            number = convert(value, dimension, what=key)
        except InputError as error:
            self.adopt(key, error)
            return 0.0 if low is None else low
        if (low is not None and number < low) or (high is not None and number > high):
            span = f"at least {low:g}" if high in (None, math.inf) else f"between {low or 0:g} and {high:g}"
            self.fault(key, f"{key} must be {span} {dimension}, found '{value}'.")
            return low if low is not None and number < low else high or 0.0
        if high is None and math.isinf(number):
            self.fault(key, f"{key} must be finite, found '{value}'.")
        return number


def _in_unit(dimension: Dimension) -> str:
    return f" [{dimension}]"


def read_toml(file: Path, text: str | None = None) -> Table:
    """Read the root table of a TOML file.

    Raises:
        InputError: The file cannot be read, is not UTF-8, or is not valid TOML; with the position of the fault.
    """
    data, positions = parse_toml(read_text(file) if text is None else text, file)
    return Table(file, data, (), positions)
