"""Schema: all kinds of nodes and all relations between them, with what they inherit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from ...errors import KnowledgeError
from ..declaration import Kind, Relation, known
from .link import faults_of, joined_kind, joined_relation, lineage, with_inherited

End = tuple[str, str]  # a node and its kind


@dataclass(frozen=True)
class Schema:
    """All kinds and relations, by name; made by `Schema.of`.

    Attributes:
        kinds: Kinds of nodes, each with the attributes that it inherits.
        relations: Relations between them.
        declared: Kinds as they were declared, without what they inherit.
        lineages: Each kind and what it is a kind of, the nearest first.
        families: Each kind and all kinds that are of it.
    """

    kinds: Mapping[str, Kind]
    relations: Mapping[str, Relation]
    declared: Mapping[str, Kind] = field(repr=False)
    lineages: Mapping[str, tuple[str, ...]] = field(repr=False)
    families: Mapping[str, frozenset[str]] = field(repr=False)

    @classmethod
    def of(cls, kinds: Iterable[Kind], relations: Iterable[Relation]) -> Schema:
        """A schema of these kinds and relations.

        Raises:
            KnowledgeError: A kind extends, or a relation names, one that does not exist; or a kind widens what it
                inherits. Tells all of it.
        """
        declared = {kind.name: kind for kind in kinds}
        joined = {relation.name: relation for relation in relations}
        if faults := [f"{'.'.join(path)}: {message}" for path, message in faults_of(declared, joined)]:
            raise KnowledgeError("\n".join(faults))
        lineages = {name: lineage(name, declared) for name in declared}
        return cls(
            {name: with_inherited(kind, declared) for name, kind in declared.items()},
            joined,
            declared,
            lineages,
            {name: frozenset(kind for kind in declared if name in lineages[kind]) for name in declared},
        )

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

    def is_a(self, kind: str, of: str) -> bool:
        """Whether one kind is another, or extends it."""
        return of in self.lineages[kind]

    def join(self, relation: Relation, source: End, target: End) -> None:
        """Check that a relation may join two nodes, each a name and its kind.

        Raises:
            KnowledgeError: It may not; lists the kinds that it joins.
        """
        for end, (node, kind), kinds in (
            ("start from", source, relation.sources),
            ("end at", target, relation.targets),
        ):
            if kind not in kinds and not any(kind in self.families[each] for each in kinds):
                raise KnowledgeError(
                    f"'{relation.name}' cannot {end} '{node}' of kind {kind}; "
                    f"it can {end} a node of: {', '.join(kinds)}."
                )

    def extended(self, kinds: Iterable[Kind] = (), relations: Iterable[Relation] = ()) -> Schema:
        """This schema with more in it.

        A kind or relation that exists gains the new attributes (and a relation the new endpoints); what is declared
        already cannot be declared otherwise, so that shipped content keeps its meaning.

        Raises:
            KnowledgeError: An attribute exists and is declared differently, or a relation names an unknown kind.
        """
        new_kinds, new_relations = dict(self.declared), dict(self.relations)
        for kind in kinds:
            new_kinds[kind.name] = joined_kind(new_kinds.get(kind.name), kind)
        for relation in relations:
            new_relations[relation.name] = joined_relation(new_relations.get(relation.name), relation)
        return Schema.of(new_kinds.values(), new_relations.values())
