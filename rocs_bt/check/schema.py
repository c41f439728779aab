"""Checking schema files: each together with what we ship and with the project's others, which it may name."""

from __future__ import annotations

from collections.abc import Iterable

from ..catalog import Catalog, Entry
from ..errors import Fault, InputError
from ..knowledge import SCHEMA, load_schema


def check_schema_file(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """All that is wrong with a schema file; what is wrong with the others is told where they are checked."""
    others = [other.path for other in catalog.list("schema") if other.path.resolve() != entry.path.resolve()]
    try:
        load_schema([*others, entry.path], SCHEMA)
    except InputError as error:
        return [fault for fault in error.faults if fault.file == entry.path]
    return ()
