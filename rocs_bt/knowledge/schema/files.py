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

import contextlib
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Final, Literal, TypeVar

from ...base.errors import Fault, InputError, KnowledgeError
from ...base.geometry import Pose2
from ...base.toml_table import Table, read_toml
from ...base.toml_text import as_toml
from ...base.units import ANGLE, LENGTH, NONE, Bounds, Dimension, Quantity, parse_unit
from ...declare import (
    Declared,
    InUnit,
    Location,
    OneOf,
    Scope,
    TableName,
    Valid,
    Value,
    Wrong,
    data_of,
    has_key,
    location_of,
    read,
    read_value,
    values_of,
)
from ...declare.write import written
from ..attribute import Attribute, Live
from ..declaration import NodeKind, Relation
from .schema import Schema, faults_of, joined_kind, joined_relation

FORMAT: Final = "schema/1"
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
_ONLY = {
    "unit": ("number", "numbers"),
    "low": ("number", "integer", "numbers"),
    "high": ("number", "integer", "numbers"),
    "size": ("numbers",),
    "choices": ("text",),
}
"""Types that have a key."""
# Keywords of the query language (docs/knowledge.md), which cannot name a kind, relation or attribute.
WORDS = frozenset(
    re.findall(r"\w+", "and or not if else inf True False no where order by descending limit give as of changed since")
)
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_ANY = Bounds(infinite=True)

V = TypeVar("V", bound="_WithAttributes")


def _is_name(text: str) -> bool:
    return _NAME.fullmatch(text) is not None and text not in WORDS


class _Keys(Declared):
    """Keys that kinds, relations and attributes have in common.

    Attributes:
        name: Name in the graph.
        doc: Description, one sentence.
    """

    _declaration: Any = None  # made of the keys when these are checked; None if one has a fault

    name: Annotated[
        str, TableName(), Valid(_is_name, "a valid name", "Use small letters, digits and _, and no query keyword.")
    ]
    doc: str = ""

    def _check(self) -> Iterator[Wrong]:
        try:
            self._declaration = self._make()
        except KnowledgeError as error:
            yield Wrong(None, str(error))

    def _make(self) -> Any:
        raise NotImplementedError


class AttributeKeys(_Keys):
    """Keys of an attribute.

    Attributes:
        type: Type of the values.
        unit: Unit of the numbers, a base unit of SI.
        required: Whether a node cannot be added without a value.
        low, high: Lowest and highest allowed number.
        size: Number of elements of a list; any without the key.
        choices: Allowed texts; any without the key.
        default: Value until the first write.
    """

    type: Annotated[str, OneOf(tuple(TYPES))]
    unit: str = "1"
    required: bool = False
    low: Annotated[float, InUnit("unit"), _ANY] = -math.inf
    high: Annotated[float, InUnit("unit"), _ANY] = math.inf
    size: Annotated[int, Bounds(1.0)] = 0
    choices: tuple[str, ...] = ()
    default: Any = None

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Note the faults of a unit other than that of the graph, and of the default value."""
        word, unit = table.data.get("type"), Quantity(1.0, NONE)
        try:
            if isinstance(text := table.data.get("unit", "1"), str):
                unit = parse_unit(text)
        except InputError as error:
            table.adopt("unit", error)
        if unit.value != 1.0:
            table.fault("unit", f"the graph holds SI units; '{text}' is not one.", f"Write '{unit.dimension}'.")
        if "default" in table and isinstance(word, str) and word in TYPES:
            try:
                read_value(_bare(word, unit.dimension).field("default"), table.data["default"])
            except InputError as error:
                table.adopt("default", error)

    def _check(self) -> Iterator[Wrong]:
        for key, types in _ONLY.items():
            if has_key(self, key) and self.type not in types:
                yield Wrong(key, f"{key} has no effect, because the type is '{self.type}'.")
        with contextlib.suppress(InputError):  # a wrong default value, which is noted
            yield from super()._check()

    def _make(self) -> Attribute:
        own = {key: value for key, value in values_of(self).items() if key not in ("name", "type", "unit")}
        bare = _bare(self.type, parse_unit(self.unit).dimension)
        if self.default is not None:
            own["default"] = read_value(bare.field("default"), self.default)
        return replace(bare, **own)


def _bare(word: str, unit: Dimension) -> Attribute:
    """Attribute of a type without bounds, as which a default value is read."""
    return Attribute(TYPES[word], POSE if word == "pose" else (unit,))


class _WithAttributes(_Keys):
    """Keys that kinds and relations have in common.

    Attributes:
        attributes: Attributes of the nodes or edges.
    """

    attributes: Mapping[str, AttributeKeys] = MappingProxyType({})

    def _check(self) -> Iterator[Wrong]:
        sound = all(keys._declaration is not None for keys in self.attributes.values())
        yield from super()._check() if sound else ()

    @property
    def _own(self) -> dict[str, Any]:
        return values_of(self) | {"attributes": {name: keys._declaration for name, keys in self.attributes.items()}}


class KindKeys(_WithAttributes):
    """Keys of a kind of node.

    Attributes:
        extends: Parent kind.
    """

    extends: str | None = None

    def _make(self) -> NodeKind:
        return NodeKind(**self._own)


class RelationKeys(_WithAttributes):
    """Keys of a relation.

    Attributes:
        sources, targets: Kinds of the nodes at which it starts and ends.
        single: Whether a new edge replaces the one that a node has.
        max_targets, max_sources: Maximum number of edges that start, and that end, at a node.
    """

    sources: tuple[str, ...]
    targets: tuple[str, ...]
    single: bool = False
    max_targets: Annotated[int | None, Bounds(1.0)] = None
    max_sources: Annotated[int | None, Bounds(1.0)] = None

    def _make(self) -> Relation:
        return Relation(**self._own)


class SchemaFile(Value):
    """Kinds of nodes and relations of the knowledge graph.

    Attributes:
        format: Format of the file.
        doc: Description.
        kind: Kinds of nodes.
        relation: Relations between nodes.
    """

    format: Literal["schema/1"]
    doc: str = ""
    kind: Mapping[str, KindKeys] = MappingProxyType({})
    relation: Mapping[str, RelationKeys] = MappingProxyType({})


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
            reader.read(table)
            table.done()
        except InputError as error:
            faults += error.faults
    if faults := [*faults, *reader.unlinked()]:
        raise InputError(*faults)
    return Schema.of(reader.kinds.values(), reader.relations.values())


class _Reader:
    """Adds schema files to a schema one by one, and keeps the position of each declaration for later faults."""

    def __init__(self, base: Schema) -> None:
        self.kinds: dict[str, NodeKind] = dict(base.declared)
        self.relations: dict[str, Relation] = dict(base.relations)
        self._places: dict[tuple[str, ...], Location] = {}

    def read(self, table: Table) -> None:
        """Read one file, and record the faults that need no other file to be found."""
        found = read(SchemaFile, table)
        for kind in found.kind.values():
            self._add("kind", kind, self.kinds, joined_kind, table)
            self.kinds.setdefault(kind.name, NodeKind(kind.name))  # one with a fault is known to what names it
        for relation in found.relation.values():
            self._add("relation", relation, self.relations, joined_relation, table)

    def _add(self, what: str, of: _WithAttributes, known: dict[str, Any], join: Any, table: Table) -> None:
        if of._declaration is None:
            return
        try:
            known[of.name] = join(known.get(of.name), of._declaration)
        except KnowledgeError as error:
            table.faults.append(Fault(str(error), *location_of(of)))
        paths = [(key,) for key in values_of(of) if has_key(of, key)] + [("attributes", key) for key in of.attributes]
        self._places |= {(what, of.name, *path): location_of(of, *path) for path in paths}

    def unlinked(self) -> list[Fault]:
        """Faults of references between declarations, such as an unknown kind in `extends`, with positions."""
        return [Fault(message, *self._places[path]) for path, message in faults_of(self.kinds, self.relations)]


def schema_text(schema: Schema) -> str:
    """The text of a schema file from which `load_schema` reads an equal schema."""
    kinds = {kind.name: _keys_of(KindKeys, kind) for kind in schema.declared.values()}
    relations = {relation.name: _keys_of(RelationKeys, relation) for relation in schema.relations.values()}
    return as_toml(data_of(SchemaFile(format=FORMAT, kind=kinds, relation=relations)), levels=3)


def _keys_of(cls: type[V], of: NodeKind | Relation) -> V:
    attributes = {name: _attribute_keys(name, attribute) for name, attribute in of.attributes.items()}
    return cls(**vars(of) | {"attributes": attributes})


def _attribute_keys(name: str, of: Attribute) -> AttributeKeys:
    word = next(word for word, kind in TYPES.items() if kind is of.type)
    unit = str(of.dimensions[0]) if of.type in (float, tuple) else "1"
    default = None if of.default is None else written(of.field("default"), of.default)
    known = vars(of) | {"name": name, "type": word, "unit": unit, "default": default}
    return AttributeKeys(**{key: known[key] for key in AttributeKeys._names})
