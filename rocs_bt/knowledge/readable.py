"""Readable: a graph of knowledge as those see it who only read: queries, drawings, exports, sharing.

The robot's own `KnowledgeGraph` is one; what it was at an earlier time is another. Whoever makes one gives the abstract
methods; the others follow from them, and may be replaced by faster ones.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from itertools import islice
from typing import Any, NamedTuple, Protocol

from ..errors import KnowledgeError
from ..geometry import Pose2
from .declaration import lookup
from .schema import Schema


class Stamp(NamedTuple):
    """When something was written."""

    t: float  # [s]
    revision: int  # of its newest change


class Readable(ABC):
    """Nodes with a kind and attributes, and edges between them, checked against a schema.

    A *row* is what is known of a node or an edge: each attribute that its kind or relation declares (None where it is
    not known), `t` [s] when it was written last, `revision` of its newest change, and for a node its `kind`. It may
    change as the graph does; whoever needs more of it, or of others, at one moment reads inside `held`.

    Attributes:
        schema: What may stand in it.
        revision: That of its newest change.
    """

    schema: Schema
    revision: int

    @abstractmethod
    def nodes(self, kind: str | None = None) -> list[str]:
        """The names of all nodes, or of those of a kind and of the kinds that extend it, as they were added.

        Raises:
            KnowledgeError: No such kind; lists what exists.
        """

    @abstractmethod
    def row(self, node: str) -> Mapping[str, Any] | None:
        """The row of a node, which nobody can change from here; None where there is no such node."""

    @abstractmethod
    def targets(self, source: str, relation: str) -> Mapping[str, Mapping[str, Any]]:
        """The rows of a node's edges of a relation, by target, as they were related; empty where there are none."""

    @abstractmethod
    def sources(self, target: str, relation: str) -> Mapping[str, Mapping[str, Any]]:
        """The rows of the edges of a relation that end at a node, by source, as they were related."""

    @abstractmethod
    def stamp(self, node: str, attribute: str | None = None) -> Stamp:
        """When a node, or one of its attributes, was written last; (-inf, 0) for never.

        Raises:
            KnowledgeError: No such node or attribute; lists what exists.
        """

    def locked(self) -> AbstractContextManager[Any]:
        """Hold the graph still while one reads; nothing to be done where nobody writes."""
        return nullcontext()

    def has(self, node: str) -> bool:
        """Whether there is such a node."""
        return self.row(node) is not None

    def kind(self, node: str) -> str:
        """The kind of a node.

        Raises:
            KnowledgeError: No such node; lists what exists.
        """
        kind: str = self._row(node)["kind"]
        return kind

    def get(self, node: str, attribute: str) -> Any:
        """The value of an attribute; None where it is not known.

        Raises:
            KnowledgeError: No such node, or its kind has no such attribute; lists what exists.
        """
        row = self._row(node)
        self._declares(node, row, attribute)
        return row[attribute]

    def attributes(self, node: str) -> dict[str, Any]:
        """All attributes of a node that are known, at one moment.

        Raises:
            KnowledgeError: No such node; lists what exists.
        """
        row = self._row(node)
        return _known(row, self.schema.kinds[row["kind"]].attributes)

    def related(self, source: str, relation: str) -> list[str]:
        """The targets of a node's relation, in the order in which they were related.

        Raises:
            KnowledgeError: No such node or relation; lists what exists.
        """
        return self._ends(source, relation, self.targets(source, relation))

    def relating(self, target: str, relation: str) -> list[str]:
        """The sources of the edges of a relation that end at a node, in the order in which they were related.

        Raises:
            KnowledgeError: No such node or relation; lists what exists.
        """
        return self._ends(target, relation, self.sources(target, relation))

    def edge(self, source: str, relation: str, target: str) -> dict[str, Any] | None:
        """The attributes of one edge that are known; None where there is no such edge.

        Raises:
            KnowledgeError: No such node or relation; lists what exists.
        """
        self._row(target)
        targets = self.targets(source, relation)
        self._ends(source, relation, targets)
        return _known(targets[target], self.schema.relation(relation).attributes) if target in targets else None

    def edges(self, relation: str | None = None) -> list[tuple[str, str, str]]:
        """All edges, or those of a relation: source, relation, target; by source, as these were added.

        Raises:
            KnowledgeError: No such relation; lists what exists.
        """
        relations = self.schema.relations if relation is None else (self.schema.relation(relation).name,)
        nodes = self.nodes()
        return [(node, each, target) for each in relations for node in nodes for target in self.targets(node, each)]

    def changed_since(self, revision: int, kind: str | None = None) -> list[str]:
        """The nodes that were added or changed after a revision, the newest first; those removed are gone.

        An edge is no part of its nodes: one that is drawn changes neither end.

        Raises:
            KnowledgeError: No such kind; lists what exists.
        """
        rows = [(node, self.row(node)) for node in self.nodes(kind)]
        found = [(row["revision"], node) for node, row in rows if row is not None and row["revision"] > revision]
        return [node for _, node in sorted(found, reverse=True)]

    def by_distance(
        self, x: float, y: float, kind: str | None = None, within: float = math.inf
    ) -> Iterator[tuple[float, str]]:
        """The nodes whose pose is known, nearest first, of equal distances the first by name.

        Args:
            x: From where, in the world frame [m].
            y: From where, in the world frame [m].
            kind: Of which kind, and kinds that extend it; any with a pose if left out.
            within: How far at most [m].

        Returns:
            Each distance [m] and node; worked out while one asks for more.

        Raises:
            KnowledgeError: No such kind; lists what exists.
        """
        found = []
        for node in self.nodes(kind):
            row = self.row(node)
            pose = None if row is None else row.get("pose")
            if isinstance(pose, Pose2) and (distance := math.hypot(pose.x - x, pose.y - y)) <= within:
                found.append((distance, node))
        return iter(sorted(found))

    def nearest(
        self, x: float, y: float, kind: str | None = None, within: float = math.inf, limit: int = 1
    ) -> list[tuple[float, str]]:
        """The first few of `by_distance`.

        Raises:
            KnowledgeError: No such kind; lists what exists.
        """
        return list(islice(self.by_distance(x, y, kind, within), limit))

    def _row(self, node: str) -> Mapping[str, Any]:
        row = self.row(node)
        return (
            lookup("node", node, dict[str, Mapping[str, Any]].fromkeys(self.nodes(), {}), "Knowledge")
            if row is None
            else row
        )

    def _declares(self, node: str, row: Mapping[str, Any], attribute: str) -> None:
        declared = self.schema.kinds[row["kind"]].attributes
        lookup(f"attribute of the {row['kind']} '{node}'", attribute, declared, "It")

    def _ends(self, node: str, relation: str, ends: Mapping[str, Any]) -> list[str]:
        if not ends:
            self._row(node)
            self.schema.relation(relation)
        return list(ends)


def _known(row: Mapping[str, Any], declared: Mapping[str, Any]) -> dict[str, Any]:
    return {name: row[name] for name in declared if row[name] is not None}


class Past(Protocol):
    """What keeps the history of a graph."""

    def as_of(self, t: float) -> Readable:
        """The graph as it was at a time [s]: with every change up to it, and none after.

        Raises:
            KnowledgeError: Nothing is kept of so long ago.
        """
        ...


class NoPast:
    """The past of a graph that nobody keeps."""

    def as_of(self, t: float) -> Readable:
        """Refuse.

        Raises:
            KnowledgeError: Always.
        """
        raise KnowledgeError(
            f"nobody keeps what was known at {t:g} s. Ask the journal of a run, or give Knowledge one as its `past`."
        )
