"""Storage of the graph: a networkx graph, and indexes that share its rows. It neither checks nor locks."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, NoReturn

from ..base.errors import KnowledgeError
from ..base.geometry import Pose2
from .attribute import Attribute
from .declaration import NodeKind, Relation
from .schema import Schema
from .spatial_index import SpatialIndex


class Row(dict[str, Any]):
    """Attribute dict of a node or an edge in the networkx graph; only `write` can change it."""

    def _refuse(self, *args: Any, **kwargs: Any) -> NoReturn:
        raise KnowledgeError("the view of the knowledge graph is read-only; write with KnowledgeGraph.set or relate.")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = _refuse

    def update(self, *args: Any, **kwargs: Any) -> None:
        """Refuse every update except the empty one that networkx makes when it creates the dict."""
        if any(args) or kwargs:
            self._refuse()

    def write(self, values: dict[str, Any], t: float, revision: int) -> None:
        """Write values, time [s] and revision; a reader without the lock sees all of them or none."""
        values["t"] = t
        values["revision"] = revision
        dict.update(self, values)  # with keys that are texts, CPython switches to no other thread meanwhile

    def __reduce__(self) -> tuple[type, tuple[dict[str, Any]]]:
        return dict, (dict(self),)


class GraphStore:
    """A networkx MultiDiGraph with edges keyed by their relation, and indexes for fast reading.

    Attributes:
        rows: Attribute dict of every node; the same objects that networkx holds.
        by_kind: Nodes by kind, including nodes of kinds that extend it, in insertion order.
        targets: Attribute dicts of outgoing edges: by (source, relation), then by target.
        sources: Attribute dicts of incoming edges: by (target, relation), then by source.
        recent: All nodes, in the order of their newest change.
        spaces: Spatial index of the nodes of each kind that has a pose, without nodes of kinds that extend it.
        around: Spatial indexes to search for nodes of a kind, including kinds that extend it; for nodes of any kind
            under None.
    """

    def __init__(self, schema: Schema) -> None:
        import networkx

        self._graph = networkx.MultiDiGraph()
        # Set on this instance and not in a subclass: copies of a view are then ordinary, writable graphs.
        self._graph.node_attr_dict_factory = Row
        self._graph.edge_attr_dict_factory = Row
        self.rows: dict[str, Row] = {}
        self.by_kind: dict[str, dict[str, None]] = {kind: {} for kind in schema.kinds}
        self.targets: dict[tuple[str, str], dict[str, Row]] = {}
        self.sources: dict[tuple[str, str], dict[str, Row]] = {}
        self.recent: dict[str, None] = {}
        self.spaces = {name: SpatialIndex() for name, kind in schema.kinds.items() if _has_pose(kind)}
        self.around: dict[str | None, tuple[SpatialIndex, ...]] = {None: tuple(self.spaces.values())}
        for name, family in schema.families.items():
            self.around[name] = tuple(self.spaces[kind] for kind in family if kind in self.spaces)
        self._lineages = schema.lineages

    @cached_property
    def view(self) -> Any:
        """A live, read-only networkx view, cached because making it is slow."""
        return self._graph.copy(as_view=True)

    def add(
        self, node: str, kind: str, declared: Mapping[str, Attribute], values: dict[str, Any], t: float, revision: int
    ) -> None:
        """Add a node."""
        self._graph.add_node(node)
        row: Row = self._graph.nodes[node]
        row.write({"kind": kind, **_defaults(declared), **values}, t, revision)
        self.rows[node] = row
        for each in self._lineages[kind]:
            self.by_kind[each][node] = None
        self.changed(node, row, moved=True)

    def changed(self, node: str, row: Row, moved: bool) -> None:
        """Update the indexes after a write of a node.

        Args:
            node: Name of the node.
            row: Attribute dict of the node.
            moved: Whether the pose of the node was written.
        """
        recent = self.recent
        if node in recent:
            del recent[node]
        recent[node] = None
        if moved and (space := self.spaces.get(row["kind"])) is not None:
            pose = row["pose"]
            if pose is None:
                space.drop(node)
            else:
                space.put(node, pose.x, pose.y)

    def remove(self, node: str) -> None:
        """Remove a node that has no edges."""
        kind = self.rows.pop(node)["kind"]
        for each in self._lineages[kind]:
            del self.by_kind[each][node]
        del self.recent[node]
        if (space := self.spaces.get(kind)) is not None:
            space.drop(node)
        self._graph.remove_node(node)

    def edges(self, node: str) -> list[tuple[str, str, str]]:
        """Every edge from or to a node, once: source, relation, target."""
        out, into = self._graph.out_edges(node, keys=True), self._graph.in_edges(node, keys=True)
        return list(dict.fromkeys((source, relation, target) for source, target, relation in (*out, *into)))

    def relate(self, edge: tuple[str, str, str], declared: Mapping[str, Attribute]) -> Row:
        """Add an edge and return its row for writing."""
        source, relation, target = edge
        self._graph.add_edge(source, target, key=relation)
        row: Row = self._graph.edges[source, target, relation]
        row.write(_defaults(declared), 0.0, 0)
        self.targets.setdefault((source, relation), {})[target] = row
        self.sources.setdefault((target, relation), {})[source] = row
        return row

    def unrelate(self, source: str, relation: str, target: str) -> None:
        """Remove an edge."""
        self._graph.remove_edge(source, target, key=relation)
        for ends, here, there in ((self.targets, source, target), (self.sources, target, source)):
            others = ends[here, relation]
            del others[there]
            if not others:
                del ends[here, relation]

    def check_limits(self, relation: Relation, source: str, target: str) -> None:
        """Check the limits of a relation before one more edge is added.

        Raises:
            KnowledgeError: A limit is reached; lists the present edges.
        """
        for most, others, end, side in (
            (relation.max_targets, self.targets.get((source, relation.name), {}), source, "targets"),
            (relation.max_sources, self.sources.get((target, relation.name), {}), target, "sources"),
        ):
            if most is not None and len(others) >= most:
                raise KnowledgeError(
                    f"'{relation.name}' allows '{end}' at most {most} {side}, and it has {', '.join(others)}; "
                    "unrelate one first."
                )


def _has_pose(kind: NodeKind) -> bool:
    return "pose" in kind.attributes and kind.attributes["pose"].type is Pose2


def _defaults(declared: Mapping[str, Attribute]) -> dict[str, Any]:
    return {name: attribute.default for name, attribute in declared.items()}
