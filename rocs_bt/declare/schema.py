"""JSON Schema of declared classes, for editors and other programs."""

from __future__ import annotations

from contextlib import suppress
from math import isfinite
from typing import Any

from ..base.errors import InputError
from ..base.units import FINITE, NONE, Bounds, Dimension, Quantity, units_of
from .fields import Declared, Field, fields_of, summary_of
from .marks import InFile, InUnit, Keys, Kinds, ReadBy, Registered, Rest, Word
from .write import written_default

_NUMBER = r"[+-]?(inf|\d+(\.\d*)?([eE][+-]?\d+)?|\.\d+([eE][+-]?\d+)?)"
_TYPES = {str: "string", bool: "boolean", int: "integer"}


def json_schema(cls: type[Declared], title: str) -> dict[str, Any]:
    """JSON Schema (2020-12) of the files of a class; one with a `base` needs no further key."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title}
    if "bases" not in cls._names:
        return schema | _table(cls, needed=True)
    based = _table(cls, needed=False)
    based["properties"]["base"] = {"type": "string"}
    return schema | {"if": {"required": ["base"]}, "then": based, "else": _table(cls, needed=True)}


def _table(cls: type[Declared], needed: bool) -> dict[str, Any]:
    """Schema of a table; without `needed`, its keys may be missing."""
    properties, required, is_open = dict[str, Any](), list[str](), False
    for each in fields_of(cls):
        if (keys := each.mark(Keys)) is not None and keys.here:
            inner = _table(keys.cls, needed)
            properties |= inner["properties"]
            required += inner["required"]
        elif (rest := each.mark(Rest)) is not None:
            properties |= dict.fromkeys(rest.keys, True)
            is_open = is_open or not rest.keys
        elif (added := each.mark(Registered)) is not None:
            for name in added.names:
                with suppress(InputError):  # `rocs-bt doctor` lists what cannot be loaded
                    properties[name] = _table(added.cls(name), needed)
        elif each.mark(ReadBy) is not None:
            is_open = True
        elif each.is_key:
            properties[each.key] = _value(each, needed)
            required += [each.key] if needed and (each.required or each.mark(InFile) is not None) else []
    schema = {"type": "object", "properties": properties, "required": required, "additionalProperties": is_open}
    return schema | {"description": summary_of(cls)}


def _value(each: Field, needed: bool) -> dict[str, Any]:
    one = _one(each, needed)
    if each.many == "list":
        one = {"anyOf": [one, {"type": "array", "items": one}]} if each.parts else {"type": "array", "items": one}
    elif each.many == "named":
        one = {"type": "object", "additionalProperties": one}
    if (word := each.mark(Word)) is not None:
        one = {"anyOf": [{"const": word.text}, one]}
    one |= {} if (default := written_default(each)) is None else {"default": default}
    return one | ({"description": each.doc} if each.doc else {})


def _one(each: Field, needed: bool) -> dict[str, Any]:
    bounds, of = each.mark(Bounds) or FINITE, each.mark(Dimension) or NONE
    if (keys := each.mark(Keys)) is not None:
        return _table(keys.cls, needed)
    if (kinds := each.mark(Kinds)) is not None:
        cases = [_case(kinds.tag, name, _table(cls, needed)) for name, cls in kinds.table().items() if name]
        return {"type": "object", "allOf": cases}
    if each.is_table:
        return {"type": "object"} if each.is_raw else _table(each.hint, needed)
    if each.parts:
        parts = [_one(part, needed) for part in each.parts]
        return {"type": "array", "prefixItems": parts, "items": False, "minItems": len(parts)}
    if each.hint is object:
        return {} if of == NONE else {"type": "string", "pattern": rf"^\s*({_quantity(of)}|[A-Za-z]\w*)\s*$"}
    if each.options:
        return {"enum": list(each.options)}
    if each.hint is Quantity or each.mark(InUnit) is not None:
        return {"type": ["number", "string"]}
    if each.hint is float and of != NONE:
        return {"type": "string", "pattern": rf"^\s*{_quantity(of)}\s*$"}
    if each.hint is float:
        return {
            "anyOf": [{"type": "number"} | _limits(bounds), {"type": "string", "pattern": rf"^\s*{_NUMBER}\s*%?\s*$"}]
        }
    return {"type": _TYPES.get(each.hint, "string")} | (_limits(bounds) if each.hint is int else {})


def _case(tag: str, name: str, table: dict[str, Any]) -> dict[str, Any]:
    return {"if": {"required": [tag], "properties": {tag: {"const": name}}}, "then": table}


def _limits(bounds: Bounds) -> dict[str, float]:
    low = "exclusiveMinimum" if bounds.above else "minimum"
    high = "exclusiveMaximum" if bounds.below else "maximum"
    return {name: limit for name, limit in ((low, bounds.low), (high, bounds.high)) if isfinite(limit)}


def _quantity(of: Dimension) -> str:
    """Pattern of a number with a unit; products of other units, such as `kg*m/s2`, are left to the reader."""
    names, product = units_of(of), r"\S+[*/].+"
    units = "|".join([*names, product if "/" not in "".join(names) else r"\S+[*/].+[*/].+"])
    return rf"{_NUMBER}\s*({units})"
