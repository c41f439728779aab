"""Cost of the change log and of files of knowledge: 10,000 nodes, relative to raw networkx, in CPU time.

Run it with `python benchmarks history`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import itertools
import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import networkx
from row import Row, size

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import EventSink, NullSink
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import ChangeLog, GraphState, from_json_text, to_json_text

NODES, WRITES = size((10_000, 50_000), (100, 1_000))


def run() -> Iterator[Row]:
    """All rows."""
    plain, log = _graph(NullSink()), ChangeLog(GraphState("R2"), keep=NODES)
    logged = _graph(log)
    rounds = [[_cpu(lambda g=graph: _write(g, NODES)) / NODES for _ in range(5)] for graph in (plain, logged)]
    without, kept = map(statistics.median, rounds)
    yield Row("history: checked write, without log", without, "us")
    yield Row("history: checked write, log that is full", kept, "us", "without log", kept / without)
    yield from _queries()


def _queries() -> Iterator[Row]:
    log = ChangeLog(GraphState("R2"))
    graph = _graph(log)
    raw = networkx.MultiDiGraph(graph.view)
    copy = _median(raw.copy)
    begin = log.changes[-1].revision
    _write(graph, WRITES)
    for later, words in ((0, "at its start"), (WRITES // 2, f"{WRITES // 2} changes later")):
        whole = ChangeLog(GraphState("R2"), changes=log.changes)
        took = _cpu(lambda whole=whole, revision=begin + later: whole.as_of(revision=revision))
        yield Row(f"history: state of all {NODES} nodes, {words}", took / 1e3, "ms", "networkx copy", took / copy)
    log.as_of()
    took = _median(log.as_of)
    yield Row(f"history: state of all {NODES} nodes, repeated", took / 1e3, "ms", "networkx copy", took / copy)
    state = log.as_of()
    took = _cpu(lambda: [state.get(f"o{i}", "radius") for i in range(NODES)]) / NODES
    yield Row("history: read an attribute of a state", took, "us")
    text = to_json_text(state)
    took = _median(lambda: to_json_text(state))
    yield Row("history: state to JSON", took / 1e3, "ms", "networkx copy", took / copy)
    took = _median(lambda: from_json_text(text, Path("k.json")))
    yield Row("history: state from JSON, checked", took / 1e3, "ms", "networkx copy", took / copy)


def _graph(sink: EventSink) -> KnowledgeGraph:
    graph = KnowledgeGraph(SimulatedClock(0.05), sink, "R2")
    for i in range(NODES):
        graph.add(f"o{i}", "object", pose=Pose2(i * 0.1, 1.0), radius=0.2)
        if i:
            graph.relate(f"o{i}", "near", f"o{i - 1}", distance=0.1)
    return graph


_ROUNDS = itertools.count(1)


def _write(graph: KnowledgeGraph, count: int) -> None:
    radius = float(next(_ROUNDS))  # a new value, since an equal one is not a change
    for i in range(count):
        graph.set(f"o{i % NODES}", radius=radius + i * 1e-6)


def _cpu(call: Callable[[], object]) -> float:
    """CPU time of a call [us]."""
    begin = time.thread_time_ns()
    call()
    return (time.thread_time_ns() - begin) / 1e3


def _median(call: Callable[[], object]) -> float:
    return statistics.median(_cpu(call) for _ in range(5))
