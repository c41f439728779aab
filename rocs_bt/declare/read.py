"""The reader: makes objects of declared classes from tables, and notes all faults, each at its key."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, cast

from ..base.errors import Fault, InputError, did_you_mean
from ..base.python_content import is_reference
from ..base.toml_table import KnownKey, Table
from ..base.units import FINITE, NONE, Bounds, Dimension, Quantity, convert, parse_quantity, parse_unit
from .fields import Declared, Field, Scope, fields_of
from .marks import Content, InFile, InUnit, Keys, Kinds, Names, ReadBy, Registered, Rest, SetByPrograms, Valid, Word
from .open import Open
from .write import known_key

D = TypeVar("D", bound=Declared)

_HARMLESS: Mapping[Any, Any] = {str: "", bool: False, int: 0, float: 0.0, Quantity: Quantity(0.0, NONE)}


@dataclass(frozen=True)
class TableKind:
    """Kind of a table, named by one of its keys.

    Attributes:
        name: Name for messages, such as `driver 'lidar'`.
        base: Class with the keys that all kinds have.
    """

    name: str
    base: type[Declared]

    def has(self, each: Field) -> bool:
        """Whether a field belongs to this kind, not to all of them."""
        return not issubclass(self.base, each.owner)


def read_root(cls: type[D], root: Table, scope: Scope | None = None) -> D:
    """Read a whole document.

    Args:
        cls: Class of the root table.
        root: Root table.
        scope: Names and content that it may use.

    Raises:
        InputError: The document has faults; contains all of them, each with its place.
    """
    made = read(cls, root, scope)
    root.done()
    return made


def read(cls: type[D], table: Table, scope: Scope | None = None, kind: TableKind | None = None) -> D:
    """Read a table; its faults are noted in it, and a value with a fault is a default or harmless.

    Args:
        cls: Class of the table.
        table: The table.
        scope: Names and content that it may use.
        kind: Kind that selected the class, for messages.
    """
    scope = scope or Scope()
    cls._prepare(table, scope)
    found: dict[str, Any] = {}
    sound = True
    for each in _in_order(cast(Any, cls)):
        before = len(table.faults)
        found[each.name] = _Reading(each, table, scope, found).value(kind)
        if len(table.faults) > before:
            within = each.is_table and not each.mark(Keys) and isinstance(table.data.get(each.key), (dict, list))
            sound = sound and (within or each.mark(Content) is not None)
    keys = [each for each in fields_of(cls) if kind is not None and each.is_key and kind.has(each)]
    if kind is not None and (lack := [f"'{each.key}'" for each in keys if each.required and each.key not in table]):
        takes = ", ".join(each.key for each in keys)
        table.fault(None, f"{kind.name} needs {', '.join(lack)}.", f"It takes: {takes}.")
        sound = False
    made = cls.__new__(cls)
    made.__dict__.update(found, _table=table)
    if sound:
        try:
            made.__post_init__()
        except InputError as error:
            table.adopt(None, error)
        for key, message, hint, of in made._check():
            (getattr(of, "_table", None) or table).fault(key, message, hint)
    return cast(D, made._made())


def read_key(each: Field, table: Table) -> Any:
    """Value of one field of a table; its faults are noted there."""
    return _Reading(each, table, Scope(), {}).value(None)


def rows_in(table: Table, key: str) -> list[dict[str, Any]]:
    """Data of the tables `[[key]]`, before these are read; none if there are others."""
    rows = table.data.get(key)
    return [row for row in rows if isinstance(row, dict)] if isinstance(rows, list) else []


def names_of(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """Names of tables, before these are read."""
    return [name for row in rows if isinstance(name := row.get("name"), str) and name]


def note_twice(table: Table, keys: Iterable[str], what: str, hint: str) -> None:
    """Note a fault at each of the tables `[[key]]` that has the name of an earlier one."""
    seen = set[str]()
    for key in keys:
        for i, row in enumerate(rows_in(table, key)):
            if (name := str(row.get("name", ""))) in seen:
                at = table.position_of((*table.key, key, i, "name"))
                table.faults.append(Fault(f"another {what} has the name '{name}'.", table.file, *at, hint))
            seen.update([name] if name else [])


@functools.cache
def _in_order(cls: Any) -> list[Field]:
    """Fields in the order of reading: those that depend on others come after them, an open table last."""
    order = {Rest: 3, ReadBy: 2, InUnit: 1}
    return sorted(fields_of(cls), key=lambda each: next((at for mark, at in order.items() if each.mark(mark)), 0))


class _Reading:
    """Reading of one field of a table."""

    def __init__(self, each: Field, table: Table, scope: Scope, done: Mapping[str, Any]) -> None:
        self.field, self.table, self.scope, self.done = each, table, scope, done
        self.key = each.key

    def value(self, kind: TableKind | None) -> Any:
        """Value of the field."""
        each, table = self.field, self.table
        if not each.is_key:
            return self._no_key()
        table.known[self.key] = known_key(each)
        if self.key in table:
            before = len(table.faults)
            found = self._many(table.data[self.key])
            return found if len(table.faults) == before or each.is_table else self._harmless()
        return self._missing(kind)

    def _no_key(self) -> Any:
        """Value of a field that is not the value of one key."""
        each, table = self.field, self.table
        if (rest := each.mark(Rest)) is not None:
            return self._rest(rest)
        if (by := each.mark(ReadBy)) is not None:
            return by.read(table, self.done)
        if (keys := each.mark(Keys)) is not None:
            return read(keys.cls, table, self.scope)
        if (added := each.mark(Registered)) is not None:
            return self._registered(added)
        return each.default if each.mark(SetByPrograms) else self._text(str(table.key[-1]) if table.key else "", None)

    def _missing(self, kind: TableKind | None) -> Any:
        each, names = self.field, self.field.mark(Names)
        if names is not None and names.all:
            return tuple(self.scope.names.get(names.kind, ()))
        if not each.required and not each.mark(InFile):
            return Open.of(self.table.child({}, self.key), {}) if each.is_raw else each.default
        if each.name in self.scope.optional:
            return self._harmless()
        if kind is None or not kind.has(each):
            self.table.fault(None, f"{self.table.label} has no '{self.key}'.", f"Add a line '{self.key} = ...'.")
        return self._harmless()

    def _harmless(self) -> Any:
        each = self.field
        if not each.required:
            return each.default
        if each.many or each.is_raw:
            return () if each.many == "list" else Open()
        return next(iter(each.options), "") if each.options else _HARMLESS.get(each.hint)

    def _rest(self, rest: Rest) -> Open:
        table = self.table
        if rest.field and self.done[rest.field] != rest.value:
            return Open.of(table, {})
        keys = rest.keys or [key for key in table.data if key not in table.known]
        found = {key: table.data[key] for key in keys if key in table}
        table.known.update(dict.fromkeys(keys, KnownKey()))
        return Open.of(table, found)

    def _registered(self, added: Registered) -> dict[str, Any]:
        table = self.table
        table.known.update(dict.fromkeys(added.names, KnownKey("a table")))
        found = dict[str, Any]()
        for name in (name for name in added.names if name in table):
            try:
                each = Field.annotated(name, added.cls(name), None, Declared)
            except InputError as error:
                table.adopt(name, error)
            else:
                found[name] = _Reading(each, table, self.scope, self.done).value(None)
        return found

    def _many(self, value: Any) -> Any:
        """Value of the key: one, a list, or a table of values by name."""
        each, table = self.field, self.table
        if (word := each.mark(Word)) is not None and value == word.text:
            return None
        if each.many == "list":
            return self._list(value)
        if each.many == "named":
            return self._named(value)
        return self._each(value, table, self.key, ())

    def _list(self, value: Any) -> Any:
        each, plain = self.field, self.field.hint in (str, int)
        if not isinstance(value, list) or (plain and any(type(one) is not each.hint for one in value)):
            return self._wrong(each.words, value)
        if each.is_table and any(not isinstance(one, dict) for one in value):
            self.table.fault(self.key, f"{self.key} must be written as [[{self.key}]] tables.")
            return ()
        return each.made(self._each(one, self.table, self.key, (i,)) for i, one in enumerate(value))

    def _parts(self, value: Any, table: Table) -> Any:
        """A list with a fixed number of values, each of a type of its own."""
        if not isinstance(value, list):
            return self._wrong("a list", value)
        if len(value) != len(parts := self.field.parts_of(value)):
            table.fault(self.key, f"{self.key} must have {len(parts)} values, found {len(value)}.")
            return self._harmless()
        readings = [_Reading(part, table, self.scope, self.done) for part in parts]
        return tuple(r._each(one, table, self.key, ()) for r, one in zip(readings, value, strict=True))

    def _named(self, value: Any) -> Any:
        each, key, table = self.field, self.key, self.table
        if not isinstance(value, dict):
            self._wrong(each.words, value)
            return {}
        inner = table.child(value, key)
        inner.known.update(dict.fromkeys(value, KnownKey()))
        if (names := each.mark(Names)) is not None:
            for name in value:
                self._named_in(names, name, inner, name)
        if not each.is_table:
            return {name: self._each(one, inner, name, ()) for name, one in value.items()}
        if bad := [name for name, one in value.items() if not isinstance(one, dict)]:
            table.fault(key, f"{key}.{bad[0]} must be a table.", f"Write it as [{key}.{bad[0]}].")
        return {n: self._each(one, table, key, (n,)) for n, one in value.items() if isinstance(one, dict)}

    def _each(self, value: Any, table: Table, key: str, path: tuple[str | int, ...]) -> Any:
        """One value of a key of a table; `path` leads from the key to it."""
        each = self.field
        if each.is_table:
            if not isinstance(value, dict):
                small = each.mark(Keys)  # all keys of such a table fit into the advice
                inner = "..." if small is None else ", ".join(f"{of.key} = ..." for of in fields_of(small.cls))
                table.fault(key, f"{key} must be a table, found {value!r}.", f"Write it as {key} = {{ {inner} }}.")
                return self._harmless()
            return self._table(table.child(value, key, *path))
        if each.parts:
            return self._parts(value, table)
        if each.hint is float:
            return self._number(value, table, key)
        if each.hint is Quantity:
            return self._quantity(value)
        if each.hint in (str, Path) or each.options:
            return self._text(value, key)
        if each.hint is int:
            return self._integer(value, table, key)
        return value if each.hint is not bool or isinstance(value, bool) else self._wrong(each.words, value)

    def _table(self, child: Table) -> Any:
        each = self.field
        if each.is_raw:
            child.known.update(dict.fromkeys(child.data, KnownKey()))
            return Open.of(child, child.data)
        if (keys := each.mark(Keys)) is not None:
            return read(keys.cls, child, self.scope)
        if (kinds := each.mark(Kinds)) is None:
            return read(each.hint, child, self.scope)
        known, name = kinds.table(), child.data.get(kinds.tag)
        if not isinstance(name, str) or not name:
            return read(known[""], child, self.scope)  # the fault is that of the tag
        cls = self.scope.load(name) if is_reference(name) else known.get(name)
        tag = next((of for of in fields_of(known[""]) if of.key == kinds.tag and of.options), None)
        if cls is None and tag is None and not is_reference(name):
            hint = did_you_mean(name, [kind for kind in known if kind], "rocs_bt").and_also(kinds.hint)
            child.fault(kinds.tag, f"no {kinds.what} is named '{name}'.", hint)
        if cls is None:
            return read(known[""], child, self.scope)
        return read(cls, child, self.scope, TableKind(f"the {kinds.what} '{name}'", each.hint))

    def _text(self, value: Any, key: str | None) -> Any:
        each, table = self.field, self.table
        if not isinstance(value, str):
            return self._wrong("a text", value)
        if each.options and value not in each.options:
            hint = did_you_mean(value, filter(None, each.options), "Valid values:")
            table.fault(key, f"invalid value '{value}' for '{key}'.", hint)
        for valid in (mark for mark in each.marks if isinstance(mark, Valid)):
            if not valid.test(value):
                empty = key is not None and not value.strip()
                table.fault(key, f"{key} is empty." if empty else f"{value!r:.80} is not {valid.what}.", valid.hint)
                return value
        if (names := each.mark(Names)) is not None and value:
            self._named_in(names, value, table, key)
        if (content := each.mark(Content)) is not None and value and (fault := self.scope.missing(content.kind, value)):
            table.adopt(key, InputError(fault))
        if each.hint is Path:
            return table.beside(value) if value else None
        return value

    def _named_in(self, names: Names, name: str, table: Table, key: str | None) -> None:
        if name not in (known := self.scope.names.get(names.kind, ())):
            table.fault(key, f"{names.fault} is named '{name}'.", did_you_mean(name, known, names.owner))

    def _integer(self, value: Any, table: Table, key: str) -> Any:
        if not isinstance(value, int) or isinstance(value, bool):
            return self._wrong("a whole number", value)
        if not (bounds := self.field.mark(Bounds) or FINITE).admit(value):
            table.fault(key, f"{key} must be {bounds.words}, found {value}.")
        return value

    def _number(self, value: Any, table: Table, key: str) -> float:
        in_unit, bounds = self.field.mark(InUnit), self.field.mark(Bounds) or FINITE
        of = self.field.mark(Dimension) or NONE
        if in_unit is not None:
            try:
                of = parse_unit(self.done[in_unit.field]).dimension / in_unit.per
            except InputError:
                return 0.0  # a fault of the unit
        try:
            number = convert(value, of, what=key)
        except InputError as error:
            table.adopt(key, error)
            return 0.0
        if not bounds.admit(number):
            table.fault(key, f"{key} must be {bounds.broken(number, of)}, found {value!r}.")
        return number

    def _quantity(self, value: Any) -> Quantity:
        bounds, nothing = self.field.mark(Bounds) or FINITE, Quantity(0.0, NONE)
        try:
            found = parse_quantity(value if isinstance(value, str) else repr(value))
        except InputError as error:
            self.table.adopt(self.key, error)
            return nothing
        if not bounds.admit(found.value):
            self.table.fault(self.key, f"{self.key} must be {bounds}, found {value!r}.")
        return found

    def _wrong(self, wanted: str, value: Any) -> Any:
        self.table.fault(self.key, f"{self.key} must be {wanted}, found {value!r}.")
        return self._harmless()
