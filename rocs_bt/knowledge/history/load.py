"""Taking saved knowledge into the graph of a later run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ...errors import Fault, KnowledgeError
from ..graph import KnowledgeGraph
from ..schema import Schema
from .importer import EdgeEntry, Importer, NodeEntry
from .state import State
from .values import plain

#: Kinds that each run declares itself, or that hold for a moment only, and all kinds that extend these.
NOT_REMEMBERED = ("robot", "part", "monitor", "analyze", "rule_set", "peer", "person", "observation")


@dataclass(frozen=True)
class LoadResult:
    """What a graph accepted.

    Attributes:
        nodes: Number of nodes, new ones and those that gained an attribute.
        edges: Number of edges.
        refused: Reasons of what the graph refused.
    """

    nodes: int
    edges: int
    refused: tuple[str, ...]


def persistent_part(state: State, schema: Schema, file: Path) -> tuple[State, list[Fault]]:
    """The part of a state that is worth remembering, and the faults of what the schema refuses.

    Left out is what belongs to a run and not to the world: the robot itself, its parts and blocks and the edges that
    start from it; observations; uses of strategies that the run's end cut off; and what may be elsewhere by now: other
    robots, people, objects that move, and objects whose place was not known.

    Args:
        state: The state at the end of an earlier run.
        schema: Kinds and relations of the present run.
        file: Its file, for the faults.
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
    """Take a state into a graph, as one write, as of now.

    What the graph holds stands: a node that is there gains attributes that nobody wrote yet, and an edge that is there
    stays as it is.
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
        return False  # it was refused already
    try:
        there = graph.related(source, relation)
        if target in there or (there and graph.schema.relation(relation).single):
            return False
        graph.relate(source, relation, target, **(state.edge(source, relation, target) or {}))
    except KnowledgeError as error:
        refused.append(str(error))
        return False
    return True
