"""Cost of knowledge access, relative to raw networkx and numpy in the same process, in CPU time.

Run it with `python benchmarks knowledge`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import itertools
import math
import statistics
import time
from collections.abc import Callable, Iterator

import networkx
import numpy as np
from row import Row, size

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.signal import Signal
from rocs_bt.event import KnowledgeChanged, NullSink
from rocs_bt.knowledge import Knowledge

SIGNALS = 500
CALLS, REPEATS = size((20_000, 9), (10, 1))


def micros(call: Callable[[], object], count: int = CALLS, repeats: int = REPEATS) -> float:
    """CPU time of one call [us]: median of several rounds, minus the empty loop."""

    def round_of(what: Callable[[], object]) -> float:
        start = time.process_time_ns()
        for _ in itertools.repeat(None, count):
            what()
        return (time.process_time_ns() - start) / count / 1e3

    def nothing() -> None:
        pass

    round_of(call)
    return statistics.median(round_of(call) - round_of(nothing) for _ in range(repeats))


def run() -> Iterator[Row]:
    """All rows."""
    knowledge = _knowledge()
    graph, signals = knowledge.graph, knowledge.signals
    raw = networkx.MultiDiGraph()
    raw.add_node("box", distance=1.0)
    distances = itertools.cycle((1.0, 2.0))
    buffer, plain = np.empty(signals.size), np.empty(signals.size)

    def subscriber(change: KnowledgeChanged) -> None:
        pass

    def raw_write() -> None:
        raw.nodes["box"]["distance"] = next(distances)

    graph.subscribe(subscriber, node="box")
    raw_read_us = micros(lambda: raw.nodes["box"]["distance"])
    raw_write_us = micros(raw_write)
    copy_us = micros(lambda: np.copyto(buffer, plain))
    read = micros(lambda: graph.get("box", "distance"))
    yield _row("read an attribute", read, "raw networkx", raw_read_us, 0.5)
    write = micros(lambda: graph.set("box", distance=next(distances)))
    yield _row("checked write, one subscriber, event emitted", write, "raw networkx", raw_write_us, 4.0)
    snapshot = micros(lambda: signals.snapshot(0.1, buffer))
    yield _row(f"snapshot of {SIGNALS} signals", snapshot, "numpy copy of the array", copy_us, 5.0)
    yield _row("write one signal of one value", micros(lambda: signals.write("s3", 1.0, 0.0)), "", None, None)
    yield _row("pose of the pursued goal", micros(lambda: _goal_pose(knowledge)), "", None, None)


def _goal_pose(knowledge: Knowledge) -> Pose2 | None:
    goal = knowledge.world.pursued()
    return None if goal is None else knowledge.world.pose_of(goal)


def _knowledge() -> Knowledge:
    knowledge = Knowledge("R2", SimulatedClock(0.05), NullSink())
    for i in range(SIGNALS):
        knowledge.signals.declare(Signal(f"s{i}", bounds=(0.0, math.inf), max_age=0.15 if i % 2 else 10.0))
    knowledge.signals.freeze()
    knowledge.signals.update(dict.fromkeys(knowledge.signals.names, 1.0), 0.0)
    knowledge.graph.add("box", "object", distance=1.0)
    knowledge.world.place("home", Pose2(1.0, 2.0), "goal")
    knowledge.world.pursue("home")
    return knowledge


def _row(name: str, value: float, baseline: str, other: float | None, budget: float | None) -> Row:
    ratio = None if other is None else value / other
    words = "" if budget is None else f"<= {budget:g} us"
    return Row(f"knowledge: {name}", value, "us", baseline, ratio, words, None if budget is None else value <= budget)
