"""Kinds of nodes and relations between them, as they are declared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from ..errors import KnowledgeError, did_you_mean
from .attribute import Attribute, Live

# What every row has, and what the writing methods call their own arguments.
RESERVED = frozenset({"kind", "t", "revision", "node", "source", "relation", "target"})


NAME_LIMIT = 200
"""Characters in a name."""

T = TypeVar("T")


def is_name(text: object) -> bool:
    """Whether a text can name a node: 1 to `NAME_LIMIT` printable characters, in every graph and from every peer.

    Control characters would reach terminals, log files and identifiers as commands.
    """
    return isinstance(text, str) and 0 < len(text) <= NAME_LIMIT and text.isprintable()


def lookup(what: str, name: str, names: Mapping[str, T], owner: str) -> T:
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
        extends: The kind that it is a kind of: it has all its attributes, and stands wherever that one may.
    """

    name: str
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    doc: str = ""
    extends: str | None = None

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
        sources: Kinds that it may start from, and all that extend them.
        targets: Kinds that it may end at, and all that extend them.
        attributes: What an edge of it may hold.
        single: Whether a source has at most one; a new edge then takes the old one's place.
        doc: One sentence for people.
        max_targets: How many a source may have at most; one more is refused. None for any number.
        max_sources: How many a target may have at most; one more is refused. None for any number.
    """

    name: str
    sources: tuple[str, ...]
    targets: tuple[str, ...]
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    single: bool = False
    doc: str = ""
    max_targets: int | None = None
    max_sources: int | None = None

    def __post_init__(self) -> None:
        _no_reserved(f"relation '{self.name}'", self.attributes)
        if self.single and self.max_targets is not None:
            raise KnowledgeError(f"relation '{self.name}' is single, so that max_targets says nothing; drop one.")
        if any(most is not None and most < 1 for most in (self.max_targets, self.max_sources)):
            raise KnowledgeError(f"relation '{self.name}' must allow at least one source and target.")
        if any(a.type is Live for a in self.attributes.values()):
            raise KnowledgeError(f"relation '{self.name}' declares a live view; only nodes can have one.")


def _no_reserved(owner: str, attributes: Mapping[str, Attribute]) -> None:
    if taken := RESERVED & attributes.keys():
        raise KnowledgeError(
            f"{owner} declares {', '.join(sorted(taken))}, which the graph uses itself; name it otherwise."
        )
