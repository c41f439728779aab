"""How kinds inherit, and what is wrong with a schema's declarations, each fault under the path of what is at fault."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from ...errors import KnowledgeError, did_you_mean
from ..attribute import Attribute
from ..declaration import Kind, Relation

Path = tuple[str, ...]
Fault = tuple[Path, str]


def lineage(name: str, kinds: Mapping[str, Kind]) -> tuple[str, ...]:
    """A kind and what it is a kind of, the nearest first; ends where a name is unknown, or comes a second time."""
    found: list[str] = []
    at: str | None = name
    while at is not None and at in kinds and at not in found:
        found.append(at)
        at = kinds[at].extends
    return tuple(found)


def with_inherited(kind: Kind, kinds: Mapping[str, Kind]) -> Kind:
    """A kind with the attributes of its ancestors, theirs first; what it declares anew takes the place of theirs."""
    attributes: dict[str, Attribute] = {}
    for name in reversed(lineage(kind.name, kinds)):
        attributes.update(kinds[name].attributes)
    return replace(kind, attributes=attributes)


def faults_of(kinds: Mapping[str, Kind], relations: Mapping[str, Relation]) -> Iterator[Fault]:
    """What is wrong between declarations, such as `(("kind", "goal", "extends"), "there is no ...")`."""
    for kind in kinds.values():
        yield from _faults_of_kind(kind, kinds)
    for relation in relations.values():
        for key, ends in (("sources", relation.sources), ("targets", relation.targets)):
            for name in ends:
                if name not in kinds:
                    hint = did_you_mean(name, kinds, "The schema")
                    yield ("relation", relation.name, key), f"there is no kind named '{name}'. {hint}"


def _faults_of_kind(kind: Kind, kinds: Mapping[str, Kind]) -> Iterator[Fault]:
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
                f"kind '{kind.name}' has '{name}' from '{kind.extends}', as {inherited[name].words}; "
                f"{kind.attributes[name].words} allows what that does not. Name it otherwise.",
            )


def joined_kind(old: Kind | None, new: Kind) -> Kind:
    """A kind with what another declaration adds to it.

    Raises:
        KnowledgeError: It declares otherwise what is declared already.
    """
    if old is None:
        return new
    if new.extends not in (None, old.extends):
        raise KnowledgeError(f"kind '{old.name}' exists and extends {old.extends or 'nothing'}; keep it so.")
    return replace(old, attributes=_merged(f"kind '{old.name}'", old.attributes, new.attributes))


def joined_relation(old: Relation | None, new: Relation) -> Relation:
    """A relation with the endpoints and attributes that another declaration adds to it.

    Raises:
        KnowledgeError: It declares otherwise what is declared already.
    """
    if old is None:
        return new
    for rule in ("single", "max_targets", "max_sources"):
        if (was := getattr(old, rule)) != getattr(new, rule):
            raise KnowledgeError(f"relation '{old.name}' exists with {rule}={was}; keep it so.")
    return replace(
        old,
        sources=tuple(dict.fromkeys((*old.sources, *new.sources))),
        targets=tuple(dict.fromkeys((*old.targets, *new.targets))),
        attributes=_merged(f"relation '{old.name}'", old.attributes, new.attributes),
    )


def _merged(owner: str, old: Mapping[str, Attribute], new: Mapping[str, Attribute]) -> dict[str, Attribute]:
    for name in old.keys() & new.keys():
        if old[name] != new[name]:
            raise KnowledgeError(f"{owner} has '{name}' already, as {old[name].words}; name the new one otherwise.")
    return {**old, **new}
