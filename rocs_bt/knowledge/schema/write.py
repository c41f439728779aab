"""Schemas as files: what `load_schema` reads, so that a schema can be kept, sent and compared."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any

from ...geometry import Pose2
from ...units import NONE, Dimension
from ..attribute import Attribute
from .load import FORMAT, TYPES
from .schema import Schema

_WORDS = {kind: word for word, kind in TYPES.items()}


def schema_text(schema: Schema) -> str:
    """A schema as the text of a schema file; `load_schema` makes an equal one of it."""
    return "\n".join([f"format = {json.dumps(FORMAT)}", *_declarations(schema)]) + "\n"


def _declarations(schema: Schema) -> Iterator[str]:
    for kind in schema.declared.values():
        yield from _table(f"kind.{kind.name}", {"doc": kind.doc, "extends": kind.extends}, kind.attributes)
    for relation in schema.relations.values():
        values: dict[str, Any] = {
            "doc": relation.doc,
            "sources": [*relation.sources],
            "targets": [*relation.targets],
            "single": relation.single,
            "max_targets": relation.max_targets,
            "max_sources": relation.max_sources,
        }
        yield from _table(f"relation.{relation.name}", values, relation.attributes)


def _table(header: str, values: Mapping[str, Any], attributes: Mapping[str, Attribute]) -> Iterator[str]:
    yield f"\n[{header}]"
    yield from (f"{key} = {_plain(value)}" for key, value in values.items() if value not in (None, "", False))
    if attributes:
        yield f"[{header}.attributes]"
    for name, attribute in attributes.items():
        yield f"{name} = {{ {', '.join(f'{key} = {value}' for key, value in _attribute(attribute))} }}"


def _attribute(attribute: Attribute) -> Iterator[tuple[str, str]]:
    kind, unit = attribute.type, attribute.dimensions[0]
    yield "type", json.dumps(_WORDS[kind])
    if kind in (float, tuple) and unit != NONE:
        yield "unit", json.dumps(str(unit))
    if attribute.required:
        yield "required", "true"
    for key, bound in (("low", attribute.low), ("high", attribute.high)):
        if not math.isinf(bound):
            yield key, _quantity(bound, unit)
    if attribute.size:
        yield "size", str(attribute.size)
    if attribute.choices:
        yield "choices", _plain([*attribute.choices])
    if attribute.default is not None:
        yield "default", _default(attribute)
    if attribute.doc:
        yield "doc", _plain(attribute.doc)


def _default(attribute: Attribute) -> str:
    value, dimensions = attribute.default, attribute.dimensions
    if attribute.type is float:
        return _quantity(value, dimensions[0])
    if isinstance(value, (tuple, Pose2)):
        each = dimensions if isinstance(value, Pose2) else dimensions * len(value)
        return f"[{', '.join(_quantity(v, d) for v, d in zip(value, each, strict=True))}]"
    return _plain(value)


def _quantity(value: float, unit: Dimension) -> str:
    return repr(value) if unit == NONE and not math.isinf(value) else json.dumps(f"{value!r} {unit}")


def _plain(value: Any) -> str:
    # TOML's texts, lists, numbers and truths are JSON's, but for DEL, which JSON leaves as it is.
    return json.dumps(value).replace("\x7f", "\\u007f")
