"""Schema files: TOML with `format = "schema/1"`, read into a Schema; all faults are reported, each at its line.

[kind.charger]
doc = "Charging station"
extends = "place"

[kind.charger.attributes]
power = { type = "number", unit = "W", low = "0 W", doc = "charging power" }

[relation.docks_at]
sources = ["robot"]
targets = ["charger"]
single = true
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from ...base.errors import Fault, InputError, KnowledgeError, UnitError
from ...base.geometry import Pose2
from ...base.toml_table import Table, read_toml
from ...base.toml_text import as_toml
from ...base.units import ANGLE, LENGTH, NONE, Dimension, convert, parse_unit
from ..attribute import Attribute, Live
from ..declaration import Kind, Relation
from .schema import Schema, faults_of, joined_kind, joined_relation

FORMAT = "schema/1"
POSE = (LENGTH, LENGTH, ANGLE)
TYPES: Mapping[str, type] = {
    "number": float,
    "integer": int,
    "flag": bool,
    "text": str,
    "numbers": tuple,
    "pose": Pose2,
    "live": Live,
}
# Keywords of the query language (docs/knowledge.md), which cannot name a kind, relation or attribute.
WORDS = frozenset(
    re.findall(r"\w+", "and or not if else inf True False no where order by descending limit give as of changed since")
)
_NAME = re.compile(r"[a-z][a-z0-9_]*")


def load_schema(files: Iterable[Path], base: Schema | None = None) -> Schema:
    """Read a schema from files, on top of a base.

    Args:
        files: Schema files. They may name each other's kinds, and add attributes to a kind, or endpoints to a
            relation, of another file or of the base.
        base: Schema to extend; None for an empty one.

    Raises:
        InputError: Every fault of every file, each at its line.
    """
    reader = _Reader(Schema.of((), ()) if base is None else base)
    faults: list[Fault] = []
    for file in files:
        try:
            table = read_toml(file)
        except InputError as error:
            faults += error.faults
            continue
        reader.read(table)
        try:
            table.done()
        except InputError as error:
            faults += error.faults
    if faults := [*faults, *reader.unlinked()]:
        raise InputError(*faults)
    return Schema.of(reader.kinds.values(), reader.relations.values())


class _Reader:
    """Adds schema files to a schema one by one, and keeps the position of each declaration for later faults."""

    def __init__(self, base: Schema) -> None:
        self.kinds: dict[str, Kind] = dict(base.declared)
        self.relations: dict[str, Relation] = dict(base.relations)
        self._positions: dict[tuple[str, ...], tuple[Path, int, int]] = {}

    def read(self, table: Table) -> None:
        """Read one file, and record the faults that need no other file to be found."""
        table.choice("format", [FORMAT])
        table.text("doc", "")
        for name, each in table.named_tables("kind").items():
            if (kind := _read(name, each, _kind)) is not None:
                with _blaming(each):
                    self.kinds[name] = joined_kind(self.kinds.get(name), kind)
                self._remember(("kind", name), each, kind.attributes)
            self.kinds.setdefault(name, Kind(name))  # one with a fault is known to what names it
        for name, each in table.named_tables("relation").items():
            if (relation := _read(name, each, _relation)) is not None:
                with _blaming(each):
                    self.relations[name] = joined_relation(self.relations.get(name), relation)
                self._remember(("relation", name), each, relation.attributes)

    def _remember(self, path: tuple[str, str], table: Table, attributes: Iterable[str]) -> None:
        for key in table.data:
            self._positions[*path, key] = table.file, *table.position(key)
        for key in attributes:
            position = table.positions.get((*table.key, "attributes", key), table.position())
            self._positions[*path, "attributes", key] = table.file, *position

    def unlinked(self) -> list[Fault]:
        """Faults of references between declarations, such as an unknown kind in `extends`, with positions."""
        return [Fault(message, *self._positions[path]) for path, message in faults_of(self.kinds, self.relations)]


@contextmanager
def _blaming(table: Table, key: str | None = None) -> Iterator[None]:
    """Context that reports a KnowledgeError of a declaration as a fault of a table's key."""
    try:
        yield
    except KnowledgeError as error:
        table.fault(key, str(error))


T = TypeVar("T")


def _read(name: str, table: Table, read: Callable[[str, Table], T]) -> T | None:
    """Read a declaration from a table; None if it has a fault, which is recorded."""
    if not _NAME.fullmatch(name) or name in WORDS:
        table.fault(
            None, f"'{name}' is not a valid name.", hint="Use small letters, digits and _, and no query keyword."
        )
    before = len(table.faults)
    declared = None
    with _blaming(table):
        declared = read(name, table)
    return declared if len(table.faults) == before else None


def _kind(name: str, table: Table) -> Kind:
    extends = table.text("extends", "") or None
    return Kind(name, _attributes(table), table.text("doc", ""), extends)


def _relation(name: str, table: Table) -> Relation:
    return Relation(
        name,
        tuple(table.texts("sources")),
        tuple(table.texts("targets")),
        _attributes(table),
        table.flag("single", False),
        table.text("doc", ""),
        table.integer("max_targets", 0, low=1) or None,
        table.integer("max_sources", 0, low=1) or None,
    )


def _attributes(table: Table) -> dict[str, Attribute]:
    found = {name: _read(name, each, _attribute) for name, each in table.named_tables("attributes").items()}
    return {name: attribute for name, attribute in found.items() if attribute is not None}


def _attribute(name: str, table: Table) -> Attribute:
    word = table.choice("type", TYPES)
    kind = TYPES.get(word, float)
    dimensions = (_unit(table),) if kind in (float, tuple) else POSE if kind is Pose2 else (NONE,)
    low, high = -math.inf, math.inf
    if kind in (float, int, tuple):
        low = table.quantity("low", dimensions[0], -math.inf, high=math.inf)
        high = table.quantity("high", dimensions[0], math.inf, high=math.inf)
    return Attribute(
        kind,
        dimensions,
        required=table.flag("required", False),
        low=low,
        high=high,
        default=_default(table, kind, dimensions),
        size=table.integer("size", 0, low=1) if kind is tuple else 0,
        choices=tuple(table.texts("choices", [])) if kind is str else (),
        doc=table.text("doc", ""),
    )


def _unit(table: Table) -> Dimension:
    """The dimension of `unit`, which must be an SI base unit, as the graph holds SI values."""
    text = table.text("unit", "1")
    try:
        unit = parse_unit(text)
    except UnitError as error:
        table.adopt("unit", error)
        return NONE
    if unit.value != 1.0:
        table.fault("unit", f"the graph holds SI units; '{text}' is not one.", hint=f"Write '{unit.dimension}'.")
    return unit.dimension


def _default(table: Table, kind: type, dimensions: tuple[Dimension, ...]) -> Any:
    """Default value in SI units, in the form that the graph stores; not yet checked. None if there is none."""
    value = table.raw("default", None)
    try:
        if kind is float and value is not None:
            return convert(value, dimensions[0], "default")
        if kind in (tuple, Pose2) and isinstance(value, list):
            each = dimensions if kind is Pose2 else dimensions * len(value)
            numbers = [convert(v, d, "default") for v, d in zip(value, each, strict=True)]
            return Pose2(*numbers) if kind is Pose2 else tuple(numbers)
    except UnitError as error:
        table.adopt("default", error)
    except ValueError:
        table.fault("default", f"default must have {len(each)} values, found {len(value)}.")
    return value


_WORDS = {kind: word for word, kind in TYPES.items()}


def schema_text(schema: Schema) -> str:
    """The text of a schema file from which `load_schema` reads an equal schema."""
    kinds = {kind.name: _declaration_data(kind, ("doc", "extends")) for kind in schema.declared.values()}
    keys = ("doc", "sources", "targets", "single", "max_targets", "max_sources")
    relations = {relation.name: _declaration_data(relation, keys) for relation in schema.relations.values()}
    return as_toml({"format": FORMAT, "kind": kinds, "relation": relations}, levels=3)


def _declaration_data(of: Kind | Relation, keys: Iterable[str]) -> dict[str, Any]:
    given = {key: value for key in keys if (value := getattr(of, key)) not in (None, "", False)}
    attributes = {name: _attribute_data(attribute) for name, attribute in of.attributes.items()}
    return given | ({"attributes": attributes} if attributes else {})


def _attribute_data(attribute: Attribute) -> dict[str, Any]:
    unit, bounds = attribute.dimensions[0], {"low": attribute.low, "high": attribute.high}
    return {
        "type": _WORDS[attribute.type],
        "unit": str(unit) if attribute.type in (float, tuple) and unit != NONE else None,
        "required": attribute.required or None,
        **{key: _quantity(bound, unit) for key, bound in bounds.items() if not math.isinf(bound)},
        "size": attribute.size or None,
        "choices": attribute.choices or None,
        "default": _default_data(attribute),
        "doc": attribute.doc or None,
    }


def _default_data(attribute: Attribute) -> Any:
    value, dimensions = attribute.default, attribute.dimensions
    if isinstance(value, (tuple, Pose2)):
        each = dimensions if isinstance(value, Pose2) else dimensions * len(value)
        return [_quantity(v, d) for v, d in zip(value, each, strict=True)]
    return _quantity(value, dimensions[0]) if isinstance(value, float) else value


def _quantity(value: float, unit: Dimension) -> float | str:
    return value if unit == NONE and not math.isinf(value) else f"{value!r} {unit}"
