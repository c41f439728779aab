"""Kinds of nodes, relations between them, and the schema that joins them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from ..errors import KnowledgeError, did_you_mean
from .attribute import Attribute, Live

# What every row has, and what the writing methods call their own arguments.
RESERVED = frozenset({"kind", "t", "revision", "node", "source", "relation", "target"})


T = TypeVar("T")


def known(what: str, name: str, names: Mapping[str, T], owner: str) -> T:
    """What a name stands for.

    Raises:
        KnowledgeError: Nothing; lists what exists.
    """
    if name in names:
        return names[name]
    raise KnowledgeError(f"there is no {what} named {name!r}. {did_you_mean(str(name), names, owner)}")


def checked(owner: tuple[str, ...], declared: Mapping[str, Attribute], given: Mapping[str, Any]) -> dict[str, Any]:
    """The values as they are stored.

    Args:
        owner: The words for whose attributes they are, such as `goal`, `home`; joined for a message only.
        declared: What it may hold.
        given: What somebody wants to write.

    Raises:
        KnowledgeError: An attribute that is not declared, or a value that it refuses.
    """
    values = {}
    for name, value in given.items():
        try:
            values[name] = declared[name].check(value)
        except KeyError:
            hint = did_you_mean(name, declared, "It")
            raise KnowledgeError(f"'{' '.join(owner)}' has no attribute '{name}'. {hint}") from None
        except KnowledgeError as error:
            raise KnowledgeError(f"attribute '{name}' of '{' '.join(owner)}' {error}") from None
    return values


@dataclass(frozen=True)
class Kind:
    """A kind of node.

    Attributes:
        name: What the graph calls it, such as `robot`.
        attributes: What a node of this kind may hold.
        doc: One sentence for people.
    """

    name: str
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    doc: str = ""

    def __post_init__(self) -> None:
        _no_reserved(f"kind '{self.name}'", self.attributes)
        signal = self.attributes.get("signal")
        if any(a.type is Live for a in self.attributes.values()) and (signal is None or signal.type is not str):
            raise KnowledgeError(f"kind '{self.name}' has a live view, but no text attribute 'signal' to name it.")


@dataclass(frozen=True)
class Relation:
    """A named relation: a directed edge from nodes of some kinds to nodes of some kinds.

    Attributes:
        name: What the graph calls it, such as `has_sensor`.
        sources: Kinds that it may start from.
        targets: Kinds that it may end at.
        attributes: What an edge of it may hold.
        single: Whether a source has at most one; a new edge then takes the old one's place.
        doc: One sentence for people.
    """

    name: str
    sources: tuple[str, ...]
    targets: tuple[str, ...]
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    single: bool = False
    doc: str = ""

    def __post_init__(self) -> None:
        _no_reserved(f"relation '{self.name}'", self.attributes)
        if any(a.type is Live for a in self.attributes.values()):
            raise KnowledgeError(f"relation '{self.name}' declares a live view; only nodes can have one.")

    def join(self, source: tuple[str, str], target: tuple[str, str]) -> None:
        """Check that this relation may join two nodes, each a name and its kind.

        Raises:
            KnowledgeError: It may not; lists the kinds that it joins.
        """
        for end, (node, kind), kinds in (("start from", source, self.sources), ("end at", target, self.targets)):
            if kind not in kinds:
                raise KnowledgeError(
                    f"'{self.name}' cannot {end} '{node}' of kind {kind}; it can {end} a node of: {', '.join(kinds)}."
                )


def _no_reserved(owner: str, attributes: Mapping[str, Attribute]) -> None:
    if taken := RESERVED & attributes.keys():
        raise KnowledgeError(
            f"{owner} declares {', '.join(sorted(taken))}, which the graph uses itself; name it otherwise."
        )


@dataclass(frozen=True)
class Schema:
    """All kinds and relations, by name.

    Attributes:
        kinds: Kinds of nodes.
        relations: Relations between them.
    """

    kinds: Mapping[str, Kind]
    relations: Mapping[str, Relation]

    @classmethod
    def of(cls, kinds: Iterable[Kind], relations: Iterable[Relation]) -> Schema:
        """A schema of these kinds and relations.

        Raises:
            KnowledgeError: A relation names a kind that does not exist.
        """
        schema = cls({k.name: k for k in kinds}, {r.name: r for r in relations})
        for relation in schema.relations.values():
            for kind in (*relation.sources, *relation.targets):
                known(f"kind for the relation '{relation.name}'", kind, schema.kinds, "The schema")
        return schema

    def kind(self, name: str) -> Kind:
        """A kind by name.

        Raises:
            KnowledgeError: No such kind; lists what exists.
        """
        return known("kind", name, self.kinds, "The schema")

    def relation(self, name: str) -> Relation:
        """A relation by name.

        Raises:
            KnowledgeError: No such relation; lists what exists.
        """
        return known("relation", name, self.relations, "The schema")

    def extended(self, kinds: Iterable[Kind] = (), relations: Iterable[Relation] = ()) -> Schema:
        """This schema with more in it.

        A kind or relation that exists gains the new attributes (and a relation the new endpoints); what is declared
        already cannot be declared otherwise, so that shipped content keeps its meaning.

        Raises:
            KnowledgeError: An attribute exists and is declared differently, or a relation names an unknown kind.
        """
        new_kinds, new_relations = dict(self.kinds), dict(self.relations)
        for kind in kinds:
            old = new_kinds.get(kind.name, kind)
            merged = _merged(f"kind '{kind.name}'", old.attributes, kind.attributes)
            new_kinds[kind.name] = Kind(kind.name, merged, old.doc)
        for relation in relations:
            was = new_relations.get(relation.name, relation)
            if was.single != relation.single:
                raise KnowledgeError(f"relation '{relation.name}' exists with single={was.single}; keep it so.")
            new_relations[relation.name] = Relation(
                relation.name,
                tuple(dict.fromkeys((*was.sources, *relation.sources))),
                tuple(dict.fromkeys((*was.targets, *relation.targets))),
                _merged(f"relation '{relation.name}'", was.attributes, relation.attributes),
                was.single,
                was.doc,
            )
        return Schema.of(new_kinds.values(), new_relations.values())


def _merged(owner: str, old: Mapping[str, Attribute], new: Mapping[str, Attribute]) -> dict[str, Attribute]:
    for name in old.keys() & new.keys():
        if old[name] != new[name]:
            raise KnowledgeError(f"{owner} has '{name}' already, as {old[name]}; name the new attribute otherwise.")
    return {**old, **new}
