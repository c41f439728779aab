"""Schema: all kinds of nodes and all relations between them, with inheritance, and checks between declarations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from ...base.errors import KnowledgeError, did_you_mean
from ..attribute import Attribute
from ..declaration import NodeKind, Relation, lookup

Path = tuple[str, ...]
Fault = tuple[Path, str]


def lineage(name: str, kinds: Mapping[str, NodeKind]) -> tuple[str, ...]:
    """A kind and its ancestors, nearest first; stops at an unknown name or a cycle."""
    found: list[str] = []
    at: str | None = name
    while at is not None and at in kinds and at not in found:
        found.append(at)
        at = kinds[at].extends
    return tuple(found)


def with_inherited(kind: NodeKind, kinds: Mapping[str, NodeKind]) -> NodeKind:
    """A kind with the attributes of its ancestors added before its own, which replace inherited ones."""
    attributes: dict[str, Attribute] = {}
    for name in reversed(lineage(kind.name, kinds)):
        attributes.update(kinds[name].attributes)
    return replace(kind, attributes=attributes)


def faults_of(kinds: Mapping[str, NodeKind], relations: Mapping[str, Relation]) -> Iterator[Fault]:
    """Faults of references between declarations, such as `(("kind", "goal", "extends"), "there is no kind ...")`."""
    for kind in kinds.values():
        yield from _faults_of_kind(kind, kinds)
    for relation in relations.values():
        for key, ends in (("sources", relation.sources), ("targets", relation.targets)):
            for name in ends:
                if name not in kinds:
                    hint = did_you_mean(name, kinds, "The schema")
                    yield ("relation", relation.name, key), f"there is no kind named '{name}'. {hint}"


def _faults_of_kind(kind: NodeKind, kinds: Mapping[str, NodeKind]) -> Iterator[Fault]:
    if kind.extends is None:
        return
    path = ("kind", kind.name, "extends")
    if kind.extends not in kinds:
        yield path, f"there is no kind named '{kind.extends}'. {did_you_mean(kind.extends, kinds, 'The schema')}"
        return
    ancestors = lineage(kind.name, kinds)
    if (again := kinds[ancestors[-1]].extends) is not None and again in ancestors:
        yield path, f"kind '{kind.name}' would be a kind of itself: {' is a '.join((*ancestors, again))}."
        return
    inherited = with_inherited(kinds[kind.extends], kinds).attributes
    for name in kind.attributes.keys() & inherited.keys():
        if not kind.attributes[name].narrows(inherited[name]):
            yield (
                ("kind", kind.name, "attributes", name),
                f"kind '{kind.name}' has '{name}' from '{kind.extends}', as {inherited[name].description}; "
                f"{kind.attributes[name].description} allows values that this does not. Choose another name.",
            )


def joined_kind(old: NodeKind | None, new: NodeKind) -> NodeKind:
    """Merge a declaration of a kind of node into the existing one; the result has the attributes of both.

    Args:
        old: Existing declaration; None for a new kind.
        new: Additional declaration.

    Raises:
        KnowledgeError: The declaration contradicts the existing one.
    """
    if old is None:
        return new
    if new.extends not in (None, old.extends):
        raise KnowledgeError(f"kind '{old.name}' exists and extends {old.extends or 'nothing'}; this cannot change.")
    return replace(old, attributes=_merged(f"kind '{old.name}'", old.attributes, new.attributes))


def joined_relation(old: Relation | None, new: Relation) -> Relation:
    """Merge a declaration of a relation into the existing one; the result has the endpoints and attributes of both.

    Args:
        old: Existing declaration; None for a new relation.
        new: Additional declaration.

    Raises:
        KnowledgeError: The declaration contradicts the existing one.
    """
    if old is None:
        return new
    for rule in ("single", "max_targets", "max_sources"):
        if (was := getattr(old, rule)) != getattr(new, rule):
            raise KnowledgeError(f"relation '{old.name}' exists with {rule}={was}; this cannot change.")
    return replace(
        old,
        sources=tuple(dict.fromkeys((*old.sources, *new.sources))),
        targets=tuple(dict.fromkeys((*old.targets, *new.targets))),
        attributes=_merged(f"relation '{old.name}'", old.attributes, new.attributes),
    )


def _merged(owner: str, old: Mapping[str, Attribute], new: Mapping[str, Attribute]) -> dict[str, Attribute]:
    for name in old.keys() & new.keys():
        if old[name] != new[name]:
            raise KnowledgeError(f"{owner} has '{name}' already, as {old[name].description}; choose another name.")
    return {**old, **new}


End = tuple[str, str]  # a node and its kind


@dataclass(frozen=True)
class Schema:
    """All kinds and relations, by name; made by `Schema.of`.

    Attributes:
        kinds: Kinds of nodes, each with its own and its inherited attributes.
        relations: Relations between nodes.
        declared: Kinds of nodes as declared, without inherited attributes.
        lineages: Each kind with its ancestors, nearest first.
        families: Each kind with all kinds that extend it, directly or not.
    """

    kinds: Mapping[str, NodeKind]
    relations: Mapping[str, Relation]
    declared: Mapping[str, NodeKind] = field(repr=False)
    lineages: Mapping[str, tuple[str, ...]] = field(repr=False)
    families: Mapping[str, frozenset[str]] = field(repr=False)

    @classmethod
    def of(cls, kinds: Iterable[NodeKind], relations: Iterable[Relation]) -> Schema:
        """Build a schema from declarations.

        Raises:
            KnowledgeError: A kind extends, or a relation names, an unknown kind, or a kind widens an inherited
                attribute; lists all faults.
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

    def kind(self, name: str) -> NodeKind:
        """A kind by name.

        Raises:
            KnowledgeError: No such kind; lists what exists.
        """
        return lookup("kind", name, self.kinds, "The schema")

    def relation(self, name: str) -> Relation:
        """A relation by name.

        Raises:
            KnowledgeError: No such relation; lists what exists.
        """
        return lookup("relation", name, self.relations, "The schema")

    def is_a(self, kind: str, of: str) -> bool:
        """Whether `kind` is the kind `of`, or extends it directly or indirectly."""
        return of in self.lineages[kind]

    def join(self, relation: Relation, source: End, target: End) -> None:
        """Check that a relation may join two nodes, each given by its name and kind.

        Raises:
            KnowledgeError: The relation may not; lists the kinds that it joins.
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

    def extended(self, kinds: Iterable[NodeKind] = (), relations: Iterable[Relation] = ()) -> Schema:
        """A schema with additional kinds and relations.

        An existing kind or relation gains the new attributes (and a relation the new endpoints). Existing declarations
        cannot be changed, so that shipped content keeps its meaning.

        Raises:
            KnowledgeError: An attribute exists and is declared differently, or a relation names an unknown kind.
        """
        new_kinds, new_relations = dict(self.declared), dict(self.relations)
        for kind in kinds:
            new_kinds[kind.name] = joined_kind(new_kinds.get(kind.name), kind)
        for relation in relations:
            new_relations[relation.name] = joined_relation(new_relations.get(relation.name), relation)
        return Schema.of(new_kinds.values(), new_relations.values())
