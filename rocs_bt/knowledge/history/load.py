"""Knowledge of earlier runs in a later one: the part that lasts, and its way into the graph."""

from __future__ import annotations

from dataclasses import dataclass

from ...base.errors import KnowledgeError
from ..graph import KnowledgeGraph
from .state import GraphState

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


def persistent_part(state: GraphState) -> GraphState:
    """Part of a state that is worth loading in later runs.

    Nodes that belong to the earlier run are excluded: the robot, its parts and blocks, observations, and uses of
    strategies that had not ended. Nodes that may have moved since are excluded too: other robots, people, moving
    objects, and objects without a known pose. Edges of excluded nodes are excluded.
    """
    lasting, part = {name for name in state.nodes() if _lasts(state, name)}, GraphState(state.agent, state.schema)
    for change in state.changes():
        if change.subject in lasting:
            part.apply(change)  # which ignores edges to nodes that are not there
    part.t, part.revision = state.t, state.revision
    return part


def load_into(graph: KnowledgeGraph, state: GraphState) -> LoadResult:
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


def _lasts(state: GraphState, name: str) -> bool:
    kind = state.kind(name)
    if any(each in state.schema.lineages[kind] for each in NOT_REMEMBERED):
        return False
    known = state.attributes(name)
    if kind == "use":
        return "outcome" in known
    return "object" not in state.schema.lineages[kind] or ("pose" in known and not known.get("moves", False))


def _take_node(graph: KnowledgeGraph, state: GraphState, name: str, refused: list[str]) -> bool:
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


def _take_edge(graph: KnowledgeGraph, state: GraphState, edge: tuple[str, str, str], refused: list[str]) -> bool:
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
