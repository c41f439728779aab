"""Readable: read-only interface of a knowledge graph, for queries, drawings, exports and sharing.

The robot's `KnowledgeGraph` and a `GraphState` of it at an earlier time implement this interface. An implementation
defines the abstract methods. The other methods use these, and an implementation may replace them by faster ones.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from itertools import islice
from typing import Any, NamedTuple

from ..base.geometry import Pose2
from .declaration import lookup
from .schema import Schema


class Stamp(NamedTuple):
    """Time of the last write and revision of the last change of a node, an edge or an attribute."""

    t: float  # [s]
    revision: int


class Readable(ABC):
    """Nodes with a kind and attributes, and edges between them, checked against a schema.

    A *row* holds the data of a node or an edge: each attribute that its kind or relation declares (None if unknown),
    `t` [s] of the last write, `revision` of its newest change, and the `kind` of a node. A row may change with the
    graph; read inside `locked` to see several values at one moment.

    Attributes:
        schema: Kinds, attributes and relations of the graph.
        revision: Revision of the graph's newest change.
    """

    schema: Schema
    revision: int

    @abstractmethod
    def nodes(self, kind: str | None = None) -> list[str]:
        """Names of all nodes, or of those of a kind and of the kinds that extend it, in insertion order.

        Raises:
            KnowledgeError: No such kind; lists what exists.
        """

    @abstractmethod
    def row(self, node: str) -> Mapping[str, Any] | None:
        """The row (see the class) of a node, read-only; None if there is no such node."""

    @abstractmethod
    def targets(self, source: str, relation: str) -> Mapping[str, Mapping[str, Any]]:
        """Rows of a node's outgoing edges of a relation, by target, in insertion order."""

    @abstractmethod
    def sources(self, target: str, relation: str) -> Mapping[str, Mapping[str, Any]]:
        """Rows of a node's incoming edges of a relation, by source, in insertion order."""

    @abstractmethod
    def stamp(self, node: str, attribute: str | None = None) -> Stamp:
        """Time and revision of the last write of a node or of one attribute; (-inf, 0) if never written.

        Raises:
            KnowledgeError: No such node or attribute; lists what exists.
        """

    def locked(self) -> AbstractContextManager[Any]:
        """Lock the graph against writes while reading; does nothing for a graph without writers."""
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
        """The value of an attribute; None if unknown.

        Raises:
            KnowledgeError: No such node, or its kind has no such attribute; lists what exists.
        """
        row = self._row(node)
        self._declares(node, row, attribute)
        return row[attribute]

    def attributes(self, node: str) -> dict[str, Any]:
        """All known attributes of a node, read at one moment.

        Raises:
            KnowledgeError: No such node; lists what exists.
        """
        row = self._row(node)
        return known(row, self.schema.kinds[row["kind"]].attributes)

    def related(self, source: str, relation: str) -> list[str]:
        """The targets of a node's outgoing edges of a relation, in insertion order.

        Raises:
            KnowledgeError: No such node or relation; lists what exists.
        """
        return self._ends(source, relation, self.targets(source, relation))

    def relating(self, target: str, relation: str) -> list[str]:
        """The sources of a node's incoming edges of a relation, in insertion order.

        Raises:
            KnowledgeError: No such node or relation; lists what exists.
        """
        return self._ends(target, relation, self.sources(target, relation))

    def edge(self, source: str, relation: str, target: str) -> dict[str, Any] | None:
        """The known attributes of one edge; None if there is no such edge.

        Raises:
            KnowledgeError: No such node or relation; lists what exists.
        """
        self._row(target)
        targets = self.targets(source, relation)
        self._ends(source, relation, targets)
        return known(targets[target], self.schema.relation(relation).attributes) if target in targets else None

    def edges(self, relation: str | None = None) -> list[tuple[str, str, str]]:
        """All edges, or those of a relation, as (source, relation, target), grouped by relation and then by source.

        Raises:
            KnowledgeError: No such relation; lists what exists.
        """
        relations = self.schema.relations if relation is None else (self.schema.relation(relation).name,)
        nodes = self.nodes()
        return [(node, each, target) for each in relations for node in nodes for target in self.targets(node, each)]

    def changed_since(self, revision: int, kind: str | None = None) -> list[str]:
        """The nodes that were added or changed after a revision, the newest first; removed nodes are not listed.

        A change of an edge does not count as a change of its nodes.

        Raises:
            KnowledgeError: No such kind; lists what exists.
        """
        rows = [(node, self.row(node)) for node in self.nodes(kind)]
        found = [(row["revision"], node) for node, row in rows if row is not None and row["revision"] > revision]
        return [node for _, node in sorted(found, reverse=True)]

    def by_distance(
        self, x: float, y: float, kind: str | None = None, within: float = math.inf
    ) -> Iterator[tuple[float, str]]:
        """The nodes with a known pose, nearest first; equal distances are ordered by name.

        Args:
            x: x of the centre, world frame [m].
            y: y of the centre, world frame [m].
            kind: Kind of the nodes, including kinds that extend it; None for every kind with a pose.
            within: Maximum distance [m].

        Returns:
            Pairs of distance [m] and node, computed on demand.

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
        """The `limit` nearest nodes, as pairs of distance [m] and node; see `by_distance`.

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


def known(row: Mapping[str, Any], declared: Mapping[str, Any]) -> dict[str, Any]:
    """Values of a row that are not unknown."""
    return {name: row[name] for name in declared if row[name] is not None}
