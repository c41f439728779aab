"""Declarations of node kinds and of the relations between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from ..base.errors import KnowledgeError, did_you_mean
from .attribute import Attribute, Live

# Names that no attribute may have: keys of every stored row, and parameter names of the graph's writing methods.
RESERVED = frozenset({"kind", "t", "revision", "node", "source", "relation", "target"})


NAME_LIMIT = 200
"""Maximum number of characters in a name."""

T = TypeVar("T")


def is_name(text: object) -> bool:
    """Whether a text can name a node: 1 to `NAME_LIMIT` printable characters.

    Control characters are refused because they would act as commands in terminals, log files and identifiers.
    """
    return isinstance(text, str) and 0 < len(text) <= NAME_LIMIT and text.isprintable()


def lookup(what: str, name: str, names: Mapping[str, T], owner: str) -> T:
    """Value of a name in a mapping; for an unknown name, an error that lists the valid ones.

    Raises:
        KnowledgeError: No such name; lists what exists.
    """
    if name in names:
        return names[name]
    raise KnowledgeError(f"there is no {what} named {name!r}. {did_you_mean(str(name), names, owner)}")


def checked(owner: tuple[str, ...], declared: Mapping[str, Attribute], given: Mapping[str, Any]) -> dict[str, Any]:
    """Check attribute values against their declarations and convert them to what is stored.

    Raises:
        KnowledgeError: An attribute is not declared, or rejects its value.
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
class NodeKind:
    """Kind of node.

    Attributes:
        name: Name in the graph, such as `robot`.
        attributes: Declared attributes of a node of this kind.
        doc: Description, one sentence.
        extends: Parent kind, or None. Nodes also have the attributes of the parent kind, and are accepted wherever the
            parent kind is.
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
    """Declaration of a relation: named, directed edges between nodes of certain kinds.

    Attributes:
        name: Name in the graph, such as `has_sensor`.
        sources: Kinds of nodes from which an edge may start, including kinds that extend these.
        targets: Kinds of nodes at which an edge may end, including kinds that extend these.
        attributes: Declared attributes of an edge.
        single: Whether a node has at most one outgoing edge of the relation; a new edge then replaces the old one.
        doc: Description, one sentence.
        max_targets: Maximum number of outgoing edges of a node; further edges are refused. None for any number.
        max_sources: Maximum number of incoming edges of a node; further edges are refused. None for any number.
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
            raise KnowledgeError(f"relation '{self.name}' is single, so max_targets has no effect; drop one.")
        if any(most is not None and most < 1 for most in (self.max_targets, self.max_sources)):
            raise KnowledgeError(f"relation '{self.name}' must allow at least one source and target.")
        if any(a.type is Live for a in self.attributes.values()):
            raise KnowledgeError(f"relation '{self.name}' declares a live view; only nodes can have one.")


def _no_reserved(owner: str, attributes: Mapping[str, Attribute]) -> None:
    if taken := RESERVED & attributes.keys():
        raise KnowledgeError(
            f"{owner} declares {', '.join(sorted(taken))}, which the graph reserves; choose another name."
        )
