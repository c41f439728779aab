"""Values by name: those as a file has them, and those of programs in SI units; wrong ones are refused at once."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from ..base.errors import Fault, InputError, unknown
from ..base.toml_table import Table
from .fields import Declared, Field, fields_of
from .open import Open, location_of
from .read import TableKind, read, read_key

D = TypeVar("D", bound=Declared)


def read_values(cls: type[D], values: Mapping[str, Any], owner: str) -> D:
    """Make an object of values by name, as a file has them: of an open table, or of options of a command.

    Args:
        cls: Class that declares them.
        values: The values; an `Open` has their places.
        owner: Their owner, such as `the family OneGap`, for messages.

    Raises:
        InputError: Names or values are not valid; contains every fault.
    """
    table = _opened(values)
    made = read(cls, table, kind=TableKind(owner, Declared))
    _refuse(table, values, owner, fields_of(cls))
    return made


def read_fields(fields: Iterable[Field], values: Mapping[str, Any], owner: str) -> dict[str, Any]:
    """Those of some fields that have a value, by name; arguments and errors as those of `read_values`."""
    table, known = _opened(values), list(fields)
    found = {each.name: read_key(each, table) for each in known if each.key in table}
    _refuse(table, values, owner, known)
    return found


def read_arguments(fields: Mapping[str, Field], values: Mapping[str, Any], owner: str) -> dict[str, Any]:
    """Arguments of a function, by name; as `read_fields`, and each required one must have a value."""
    table = _opened(values)
    if missing := [each.key for each in fields.values() if each.required and each.key not in table]:
        table.fault(None, f"{owner} needs {', '.join(missing)}.", f"It takes: {', '.join(fields)}.")
    found = {name: read_key(each, table) for name, each in fields.items() if each.key in table}
    _refuse(table, values, owner, fields.values())
    return found


def _opened(values: Mapping[str, Any]) -> Table:
    return (values if isinstance(values, Open) else Open(values)).opened()


def _refuse(table: Table, values: Mapping[str, Any], owner: str, fields: Iterable[Field]) -> None:
    """Raise the faults of values, and of names that no field has."""
    start, known = f"{owner[:1].upper()}{owner[1:]}", [each.key for each in fields]
    for name in values:
        if name not in table.known:
            table.adopt(name, InputError(unknown("parameter", name, known, start)))
    if table.faults:
        has_file = isinstance(values, Open) and location_of(values).file is not None
        raise InputError(*(fault if has_file else replace(fault, file=None) for fault in table.faults))


def read_value(each: Field, value: object) -> Any:
    """One value of a field, as a file has it.

    Raises:
        InputError: The value is not valid.
    """
    return read_fields([each], {each.key: value}, each.name)[each.name]


def checked(cls: type[D], values: Mapping[str, Any], what: str) -> D:
    """Make an object from values that a program gives, SI units.

    Args:
        cls: Class of the object.
        values: Values by name.
        what: Name of the object in messages, such as `gyro 'imu'`.

    Raises:
        InputError: Names are unknown or missing, or values are wrong; contains all faults.
    """
    fields = {each.name: each for each in fields_of(cls)}
    given = {name: tuple(v) if isinstance(v, list) else v for name, v in values.items()}
    lack = [name for name, each in fields.items() if each.required and name not in values]
    refuse_faults(fields, given, what, lack)
    made = cls(**given)
    if faults := [Fault(f"{what}: {wrong.message}", hint=wrong.hint) for wrong in made._check()]:
        raise InputError(*faults)
    return made


def refuse_faults(
    fields: Mapping[str, Field], values: Mapping[str, Any], what: str, missing: Collection[str] = ()
) -> None:
    """Refuse wrong values of fields that a program gives, SI units; errors as those of `checked`."""
    faults = [unknown(f"parameter of {what}", name, fields, what) for name in values if name not in fields]
    if missing:
        faults.append(Fault(f"{what} needs {', '.join(missing)}.", hint=f"It takes: {', '.join(fields)}."))
    faults += [f for name, v in values.items() if name in fields for f in fields[name].faults(v, f"{name} of {what}")]
    if faults:
        raise InputError(*faults)
