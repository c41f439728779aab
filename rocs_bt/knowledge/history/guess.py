"""What a schema would have to declare for what a file holds of another project: guessed from the values themselves."""

from __future__ import annotations

from dataclasses import replace

from ...event import Value
from ..attribute import Attribute
from ..declaration import Kind, Relation
from ..schema import Schema

_TYPES: dict[type, type] = {list: tuple}


def with_kind(schema: Schema, kind: str) -> Schema:
    """The schema with a kind that it lacks."""
    return schema.extended(kinds=(Kind(kind),))


def with_attribute(schema: Schema, kind: str, name: str, value: Value) -> Schema:
    """The schema with an attribute of a kind, of the type of a value."""
    return schema.extended(kinds=(Kind(kind, {name: _attribute(value)}),))


def with_relation(schema: Schema, relation: str, source: str, target: str) -> Schema:
    """The schema with a relation that it lacks, between two kinds."""
    return schema.extended(relations=(Relation(relation, (source,), (target,)),))


def with_edge_attribute(schema: Schema, relation: str, name: str, value: Value) -> Schema:
    """The schema with an attribute of a relation, of the type of a value."""
    return schema.extended(relations=(replace(schema.relation(relation), attributes={name: _attribute(value)}),))


def _attribute(value: Value) -> Attribute:
    return Attribute(_TYPES.get(type(value), type(value)))
