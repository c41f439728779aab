"""Open tables: values with keys that others declare, such as the parameters of a mission, with their places."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..base.toml_table import Table
from ..base.toml_text import Key

Place = tuple[Path | None, int, int]
"""File, line and column of a value; `(None, 0, 0)` for one made by a program."""


class Open(dict[str, Any]):
    """Values of an open table as in the file, unconverted.

    Attributes:
        table: Table of the values; None for values made by a program.
    """

    table: Table | None = None

    @classmethod
    def of(cls, table: Table, values: Mapping[str, Any]) -> Open:
        """Values of a table."""
        found = cls(values)
        found.table = table
        return found

    def opened(self) -> Table:
        """Table of the values, for one reading."""
        of = self.table
        return Table(Path(), self, (), {}) if of is None else Table(of.file, self, of.key, of.positions)


def place_of(values: Mapping[str, Any], key: str = "") -> Place:
    """File, line and column of a key of an open table, or of the table itself for an empty or unknown key."""
    table = values.table if isinstance(values, Open) else None
    return (None, 0, 0) if table is None else (table.file, *table.position(key if key in values else None))


def positions_of(values: Mapping[str, Any]) -> Mapping[str, tuple[int, int]]:
    """Line and column of each value of an open table, also of those in its tables, as `TABLE.KEY`."""
    table = values.table if isinstance(values, Open) else None
    return {} if table is None else dict(_positions(table, values, ()))


def _positions(table: Table, values: Mapping[str, Any], above: Key) -> Iterator[tuple[str, tuple[int, int]]]:
    for key, value in values.items():
        path = (*above, key)
        yield ".".join(map(str, path)), table.position_of((*table.key, *path))
        if isinstance(value, dict):
            yield from _positions(table, value, path)
