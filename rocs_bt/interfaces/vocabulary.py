"""Vocabularies of nodes for missions in XML, which packages register in `rocs_bt.nodes` by the name of the dialect."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from ..base.registered import all_of

if TYPE_CHECKING:
    from ..trees.board import Board
    from ..trees.nodes import Node, Registry

NATIVE: Final = "rocs"
"""Dialect with rocs_bt's own nodes only."""


@dataclass(frozen=True)
class Vocabulary:
    """Vocabulary of nodes. It has functions, so that no node is loaded before a mission uses it.

    Attributes:
        nodes: All node classes of a mission in this dialect, for one of its distributions; None for no dialect.
        anywhere: Node classes that are added to missions of every dialect.
        distributions: Distributions that a dialect may name, as in `nav2:humble`, the newest last.
        named: Attribute of a `<Metadata>` element in which a mission names its distribution.
        title: Name in messages. Missions are recognised by nodes that only this vocabulary has; empty: they are not.
        about: Clause about a recognised mission, for its note.
        hint: Hint of this note.
        common: Names of nodes by which no mission is recognised.
        inputs: Keys of the blackboard that are parameters of a mission.
        begin: Writes to the blackboard before the first tick; it gets the keys that the mission uses.
        routes: Names of the route planners that nodes use by default.
    """

    nodes: Callable[[str], Registry] | None = None
    anywhere: Callable[[], Sequence[type[Node]]] = tuple
    distributions: Sequence[str] = ()
    named: str = ""
    title: str = ""
    about: str = ""
    hint: str = ""
    common: frozenset[str] = frozenset()
    inputs: Sequence[str] = ()
    begin: Callable[[Board, Collection[str]], None] = lambda board, used: None
    routes: Sequence[str] = ()


def vocabularies() -> Mapping[str, Vocabulary]:
    """The registered vocabularies by name."""
    return dict(all_of("rocs_bt.nodes"))


def dialects() -> tuple[str, ...]:
    """Names of all dialects: rocs_bt's own, and those of packages, also with a distribution, as in `nav2:humble`."""
    families = {name: known.distributions for name, known in vocabularies().items() if known.nodes is not None}
    return (NATIVE, *(f"{name}{of}" for name, known in families.items() for of in ("", *(f":{d}" for d in known))))


def vocabulary_of(dialect: str) -> tuple[Vocabulary | None, str]:
    """Vocabulary of a dialect and the distribution that it means; None for rocs_bt's own."""
    family, _, distribution = dialect.partition(":")
    found = vocabularies().get(family)
    if found is None or found.nodes is None:
        return None, ""
    return found, distribution or (found.distributions[-1] if found.distributions else "")
