"""Open tables: values with keys that others declare, such as the parameters of a mission, with their locations."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ..base.toml_table import Table


class Location(NamedTuple):
    """File, line and column of a value; see `NOWHERE`."""

    file: Path | None
    line: int
    column: int


NOWHERE = Location(None, 0, 0)
"""Location of a value made by a program."""


class Open(dict[str, Any]):
    """Values of an open table as in the file, unconverted."""

    _table: Table | None = None  # None for values made by a program

    @classmethod
    def of(cls, table: Table, values: Mapping[str, Any]) -> Open:
        """Values of a table."""
        found = cls(values)
        found._table = table
        return found

    def opened(self) -> Table:
        """Table of the values, for one reading."""
        of = self._table
        return Table(Path(), self, (), {}) if of is None else Table(of.file, self, of.key, of.positions)


def location_of(of: object, *key: str | None) -> Location:
    """Location of a key of a declared object or an open table, which may lead into tables, or of the table itself."""
    table: Table | None = getattr(of, "_table", None)
    path = () if table is None else (*table.key, *filter(None, key))
    return NOWHERE if table is None else Location(table.file, *table.position_of(path))


def has_key(of: object, key: str) -> bool:
    """Whether the file has a key in the table of a declared object."""
    table: Table | None = getattr(of, "_table", None)
    return table is not None and key in table
