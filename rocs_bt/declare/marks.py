"""Marks in the annotations of declared classes: which values of a key are valid."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, cast

from ..base.registered import FILES_WITH_TABLES, load, registered
from ..base.toml_table import Table
from ..base.units import NONE, Dimension


@dataclass(frozen=True)
class Key:
    """Mark of a field with another name in the file than in Python."""

    name: str


@dataclass(frozen=True)
class Keys:
    """Mark of a value, such as a pose, that a declared class makes of a table (see `Declared._made`).

    Attributes:
        cls: Class that declares the keys.
        here: Whether the keys are in the table of the field itself and not in one of their own.
    """

    cls: type[Any]
    here: bool = False


@dataclass(frozen=True)
class Names:
    """Mark of texts that name things that the document itself declares, listed in `Scope.names`.

    In a table of values by name, the names are its keys.

    Attributes:
        kind: Kind of the things in the scope.
        fault: Beginning of the message.
        owner: Owner of the names, for the hint.
        all: Whether a list that is not given has all names.
    """

    kind: str
    fault: str
    owner: str = "The scenario"
    all: bool = False


@dataclass(frozen=True)
class Content:
    """Mark of texts that name content of a kind; `Scope.missing` says what does not exist."""

    kind: str


@dataclass(frozen=True)
class Valid:
    """Mark of a text that has to pass a test.

    Attributes:
        test: Whether a text is valid.
        what: Name of a valid text, such as `a valid name`.
        hint: Advice.
    """

    test: Callable[[str], bool]
    what: str
    hint: str


@dataclass(frozen=True)
class OneOf:
    """Mark of a text that is one of several; for texts that are computed. Others are a `Literal`."""

    options: tuple[str, ...]


@dataclass(frozen=True)
class Word:
    """Mark of a value that may be this word instead, which is read as None."""

    text: str


@dataclass(frozen=True)
class Option:
    """Mark of an option of a command or of a run.

    Attributes:
        flags: Names on the command line, such as `--for`; empty if only programs give the option.
        metavar: Name of the value on the command line.
        path: Kind of valid paths; empty for both.
        stage: Kind of run that has the option, `simulation` or `hardware`; empty for both.
        late: Whether a run takes the option after its preparation. All others affect what happens in the run, and are
            part of the command line that repeats it.
    """

    flags: tuple[str, ...] = ()
    metavar: str | None = None
    path: Literal["", "file", "folder"] = "file"
    stage: Literal["", "simulation", "hardware"] = ""
    late: bool = False


@dataclass(frozen=True)
class InUnit:
    """Mark of numbers with the dimension of the unit that another field names.

    Attributes:
        field: The other field.
        per: Dimension by which that of the unit is divided, such as a time.
    """

    field: str
    per: Dimension = NONE


@dataclass(frozen=True)
class Rest:
    """Mark of an open table: all other keys of the table, as an `Open`.

    Attributes:
        keys: Keys that it takes; any key if empty.
        field, value: The field that must have the value for the table to be open; empty for any.
    """

    keys: tuple[str, ...] = ()
    field: str = ""
    value: str = ""


@dataclass(frozen=True)
class ReadBy:
    """Mark of a value that a function makes of the table, after all other fields but those with `Rest`.

    Attributes:
        read: Takes the table and the values of the other fields; asks the table for the keys that it knows.
    """

    read: Callable[[Table, Mapping[str, Any]], Any]


@dataclass(frozen=True)
class Registered:
    """Mark of the tables that packages add to a kind of file, by name; registered in `rocs_bt.tables` as `KIND.NAME`.

    Attributes:
        kind: Kind of the files, such as `robot`.
    """

    kind: str

    @property
    def names(self) -> Mapping[str, str]:
        """Names under which the tables are registered, by the name of the table.

        Tables with a registered name of no kind of file are included, so that a file with one is refused with the
        reason (see `cls`), and not as one with an unknown key.
        """
        found = dict[str, str]()
        for full in registered("rocs_bt.tables"):
            kind, _, name = full.rpartition(".")
            if kind == self.kind or (kind not in FILES_WITH_TABLES and name not in found):
                found[name] = full
        return found

    def cls(self, name: str) -> type[Any]:
        """Class that declares a table.

        Raises:
            InputError: It cannot be loaded, or is registered under a name that no file has.
        """
        return cast("type[Any]", load("rocs_bt.tables", self.names[name]))


@dataclass(frozen=True)
class Kinds:
    """Mark of tables of which a key selects the class.

    Attributes:
        tag: Key with the name of the kind.
        table: Returns the classes by name; the class of the name `""` reads a table of an unknown
            kind, and of a user's class that is not loaded.
        what: Noun for a kind, such as `driver`.
        hint: Last sentence of the hint for an unknown kind.
    """

    tag: str
    table: Callable[[], Mapping[str, type[Any]]]
    what: str
    hint: str = ""


class TableName:
    """Mark of a text that is the name of the table, as in `[perturbation.NAME]`."""


class InFile:
    """Mark of a field that a file must give, though it has a default in Python."""


class SetByPrograms:
    """Mark of a field that is no key of a file."""
