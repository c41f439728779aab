"""The writer: the data of a table, as a file has it, from an object of a declared class."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Any

from ..base.toml_table import KnownKey
from ..base.units import NONE, Dimension, parse_unit
from .fields import Declared, Field, fields_of, given_of
from .marks import InFile, InUnit, Keys, Names, ReadBy, Registered, Rest, Word


def data_of(value: Declared) -> dict[str, Any]:
    """Data of the table from which `read` makes an equal object: values other than the defaults, numbers with units."""
    given, data = given_of(value), dict[str, Any]()
    for each in fields_of(type(value)):
        has_all = (names := each.mark(Names)) is not None and names.all  # an empty list is no default
        if each.name not in given and not each.mark(InFile) and not has_all:
            continue
        found, keys = vars(value)[each.name], each.mark(Keys)
        if found != found:  # NaN, a number that is not given
            continue
        if each.mark(Rest):
            data |= found
        elif each.mark(ReadBy) or each.mark(Registered):
            data |= data_of(found) if isinstance(found, Declared) else _tables(found)
        elif keys is not None and keys.here:
            data |= _keys(keys.cls, found)
        elif each.is_key:
            data[each.key] = written(_in_unit(each, vars(value)), found)
    return data


def written(each: Field, value: Any) -> Any:
    """A value of a field as a file has it."""
    if value is None:
        return word.text if (word := each.mark(Word)) is not None else None
    if each.many == "list":
        return [_one(each, one) for one in value]
    if each.many == "named":
        return {name: _one(each, one) for name, one in value.items()}
    return _one(each, value)


def known_key(each: Field) -> KnownKey:
    """A field as editors show it."""
    return KnownKey(each.words, each.options, written_default(each), each.required, each.doc)


def written_default(each: Field) -> Any:
    """Default of a field as a file has it, such as `0.5 s`; None if there is none that a file can have."""
    default = each.default
    if isinstance(default, str):
        return default
    return written(each, default) if isinstance(default, (bool, int, float)) and isfinite(default) else None


def _one(each: Field, value: Any) -> Any:
    if (keys := each.mark(Keys)) is not None:
        return _keys(keys.cls, value)
    if each.parts:
        return [written(part, one) for part, one in zip(each.parts_of(value), value, strict=True)]
    if isinstance(value, Declared):
        return data_of(value)
    if isinstance(value, Mapping):
        return _tables(value)
    if isinstance(value, Path):
        return str(value)
    dimension = each.mark(Dimension) or NONE
    if each.hint is float and dimension != NONE:
        return f"{repr(float(value)).removesuffix('.0')} {dimension}"
    return value


def _in_unit(each: Field, values: Mapping[str, Any]) -> Field:
    """The field with the dimension of the unit that another field names."""
    unit = each.mark(InUnit)
    of = () if unit is None else (parse_unit(values[unit.field]).dimension / unit.per,)
    return replace(each, marks=(*each.marks, *of), parts=tuple(_in_unit(part, values) for part in each.parts))


def _tables(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: data_of(one) if isinstance(one, Declared) else one for name, one in values.items()}


def _keys(cls: type[Declared], value: Any) -> dict[str, Any]:
    """Keys of a value that a class makes of its table: a tuple, or an object with attributes of the same names."""
    names = [each.name for each in fields_of(cls)]
    parts = value if isinstance(value, tuple) else [getattr(value, name) for name in names]
    return data_of(cls(**dict(zip(names, parts, strict=True))))
