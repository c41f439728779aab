"""One way to declare a named value: a key of a file is a field of an annotated class (docs/architecture.md)."""

from .fields import Declared, Field, Scope, Value, Wrong, fields_of
from .marks import (
    Content,
    InFile,
    InUnit,
    Key,
    Keys,
    Kinds,
    Names,
    OneOf,
    Rest,
    SetByPrograms,
    TableName,
    Valid,
    Word,
)
from .open import Open, Place, place_of, positions_of
from .read import names_of, note_twice, read, read_root, read_value, read_values, rows_in

__all__ = [
    "Content",
    "Declared",
    "Field",
    "InFile",
    "InUnit",
    "Key",
    "Keys",
    "Kinds",
    "Names",
    "OneOf",
    "Open",
    "Place",
    "Rest",
    "Scope",
    "SetByPrograms",
    "TableName",
    "Valid",
    "Value",
    "Word",
    "Wrong",
    "fields_of",
    "names_of",
    "note_twice",
    "place_of",
    "positions_of",
    "read",
    "read_root",
    "read_value",
    "read_values",
    "rows_in",
]
