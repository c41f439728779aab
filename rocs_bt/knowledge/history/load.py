"""Loading of saved knowledge into the graph of a later run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ...base.errors import Fault, KnowledgeError
from ..graph import KnowledgeGraph
from ..schema import Schema
from .importer import EdgeEntry, Importer, NodeEntry
from .state import State
from .values import plain

#: Kinds of nodes that are not loaded, because each run adds them itself or because they are valid only briefly. Kinds
#: that extend these are not loaded either.
NOT_REMEMBERED = ("robot", "part", "monitor", "analyze", "rule_set", "peer", "person", "observation")


@dataclass(frozen=True)
class LoadResult:
    """Result of loading a state into a graph.

    Attributes:
        nodes: Number of nodes that were added or gained an attribute.
        edges: Number of added edges.
        refused: Error message for each node and edge that the graph refused.
    """

    nodes: int
    edges: int
    refused: tuple[str, ...]


def persistent_part(state: State, schema: Schema, file: Path) -> tuple[State, list[Fault]]:
    """Part of a state that is worth loading in later runs, and faults of nodes and edges that the schema refuses.

    Nodes that belong to the earlier run are excluded: the robot, its parts and blocks, observations, and uses of
    strategies that had not ended. Nodes that may have moved since are excluded too: other robots, people, moving
    objects, and objects without a known pose. Edges of excluded nodes are excluded.

    Args:
        state: State at the end of an earlier run.
        schema: Kinds and relations of the present run.
        file: File of the state, for the faults.
    """
    importer = Importer(file, state.agent, schema)
    importer.state.t, importer.state.revision = state.t, state.revision
    for name in state.nodes():
        if _lasts(state, name):
            written = {a: plain(state.get(name, a)) for a in state.written(name)}
            stamps = {a: (stamp.t, stamp.revision) for a, stamp in state.written(name).items()}
            stamp = state.stamp(name)
            importer.node(NodeEntry(name, state.kind(name), stamp.t, stamp.revision, written, stamps))
    for source, relation, target in state.edges():
        if importer.state.has(source) and importer.state.has(target):
            row = state.targets(source, relation)[target]
            known = {a: plain(v) for a, v in (state.edge(source, relation, target) or {}).items()}
            importer.edge(EdgeEntry(source, relation, target, row["t"], row["revision"], known))
    return importer.state, importer.faults


def load_into(graph: KnowledgeGraph, state: State) -> LoadResult:
    """Add a state to a graph, as one write at the present time.

    Nodes and edges of the graph have priority: an existing node gains only attributes that were never written, and an
    existing edge does not change.
    """
    refused: list[str] = []
    nodes = edges = 0
    with graph.locked():
        for name in state.nodes():
            nodes += _take_node(graph, state, name, refused)
        for edge in state.edges():
            edges += _take_edge(graph, state, edge, refused)
    return LoadResult(nodes, edges, tuple(refused))


def _lasts(state: State, name: str) -> bool:
    kind = state.kind(name)
    if any(each in state.schema.lineages[kind] for each in NOT_REMEMBERED):
        return False
    known = state.attributes(name)
    if kind == "use":
        return "outcome" in known
    return "object" not in state.schema.lineages[kind] or ("pose" in known and not known.get("moves", False))


def _take_node(graph: KnowledgeGraph, state: State, name: str, refused: list[str]) -> bool:
    written = {a: state.get(name, a) for a in state.written(name)}
    try:
        if not graph.has(name):
            graph.add(name, state.kind(name), **written)
            return True
        if graph.kind(name) != state.kind(name):
            raise KnowledgeError(f"'{name}' was of kind {state.kind(name)}, and is of kind {graph.kind(name)} now.")
        new = {a: value for a, value in written.items() if graph.stamp(name, a).revision == 0}
        graph.set(name, **new)
    except KnowledgeError as error:
        refused.append(str(error))
        return False
    return bool(new)


def _take_edge(graph: KnowledgeGraph, state: State, edge: tuple[str, str, str], refused: list[str]) -> bool:
    source, relation, target = edge
    if not (graph.has(source) and graph.has(target)):
        return False  # its node was refused already
    try:
        there = graph.related(source, relation)
        if target in there or (there and graph.schema.relation(relation).single):
            return False
        graph.relate(source, relation, target, **(state.edge(source, relation, target) or {}))
    except KnowledgeError as error:
        refused.append(str(error))
        return False
    return True
