"""Real threads that write and read at once, switched as often as the interpreter can."""

from __future__ import annotations

import math
import sys
import threading
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from rocs_bt.base.clock import WallClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.signal import Signal
from rocs_bt.event import KnowledgeChanged, ListSink
from rocs_bt.knowledge import Knowledge, KnowledgeGraph

WRITES = 1000
# So large that numpy lets other threads run while it copies, and that they do.
LARGE = 40_000
LARGE_WRITES = 300


@pytest.fixture(autouse=True)
def _switch_often() -> Iterator[None]:
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


def run_together(writers: list[Callable[[], None]], readers: list[Callable[[], None]]) -> None:
    """Readers go round until all writers are done; what any of them raises, fails the test."""
    errors: list[BaseException] = []
    done = threading.Event()
    begin = threading.Barrier(len(writers) + len(readers))

    def guarded(body: Callable[[], None]) -> None:
        try:
            begin.wait(30.0)
            body()
        except BaseException as error:  # noqa: BLE001 - handed to the test
            errors.append(error)

    def go_round(read: Callable[[], None]) -> Callable[[], None]:
        def body() -> None:
            read()
            while not done.is_set():
                read()

        return body

    writing = [threading.Thread(target=guarded, args=(w,)) for w in writers]
    reading = [threading.Thread(target=guarded, args=(go_round(r),)) for r in readers]
    for thread in (*writing, *reading):
        thread.start()
    for thread in writing:
        thread.join(60.0)
    done.set()
    for thread in reading:
        thread.join(60.0)
    assert errors == []
    assert not any(t.is_alive() for t in (*writing, *reading))


def test_no_snapshot_is_torn_and_no_write_is_lost() -> None:
    knowledge = Knowledge("R2", WallClock(), ListSink())
    signals = knowledge.signals
    for name in ("a", "b", "left", "right"):
        signals.declare(Signal(name, LARGE, bounds=(0.0, math.inf), max_age=1e9))
    signals.freeze()
    signals.update({name: np.zeros(LARGE) for name in signals.names}, 0.0)
    seen: set[float] = set()

    def write_one(name: str) -> Callable[[], None]:
        def body() -> None:
            writer = signals.writer(name)
            for k in range(1, LARGE_WRITES + 1):
                writer.write(np.full(LARGE, float(k)), float(k))

        return body

    def write_pair() -> None:
        for k in range(1, LARGE_WRITES + 1):
            signals.update({"left": np.full(LARGE, float(k)), "right": np.full(LARGE, float(k))}, float(k))

    def snapshots() -> Callable[[], None]:
        buffer, last = np.empty(signals.size), np.zeros(4)

        def body() -> None:
            values = signals.snapshot(0.0, buffer).reshape(4, LARGE)
            assert (values == values[:, :1]).all(), "a vector shows values of two writes"
            assert values[2, 0] == values[3, 0], "one sample was seen in part"
            assert (values[:, 0] >= last).all(), "an older value came back"
            last[:] = values[:, 0]
            seen.add(float(last[2]))

        return body

    def reads() -> None:
        values = signals.read("a", 0.0)
        assert (values == values[0]).all()

    run_together([write_one("a"), write_one("b"), write_pair], [snapshots(), snapshots(), reads])
    assert len(seen) > 2, "the readers never ran between writes"
    assert signals.revision == 4 * (LARGE_WRITES + 1)
    assert [signals.revision_of(n) for n in signals.names] == [LARGE_WRITES + 1] * 4
    assert signals.snapshot(0.0).min() == LARGE_WRITES


def test_a_value_and_its_age_belong_together() -> None:
    # Old stamps carry -1: a reader at time 10 must see only the fresh writes, or NaN.
    signals = Knowledge("R2", WallClock(), ListSink()).signals
    signals.declare(Signal("x", LARGE, max_age=1.0))
    signals.declare(Signal("y", max_age=1.0))
    signals.freeze()

    def write() -> None:
        for _ in range(LARGE_WRITES):
            signals.update({"x": np.full(LARGE, -1.0), "y": -1.0}, 0.0)
            signals.update({"x": np.full(LARGE, 1.0), "y": 1.0}, 10.0)

    def read() -> None:
        assert not (signals.snapshot(10.0) == -1.0).any()
        assert not (signals.read("x", 10.0) == -1.0).any()
        assert signals.value("y", 10.0) != -1.0

    run_together([write], [read, read])


def test_no_change_of_the_graph_is_lost_or_told_out_of_order() -> None:
    sink = ListSink()
    graph = KnowledgeGraph(WallClock(), sink, "R2")
    graph.add("R2", "robot")
    heard: list[int] = []
    graph.subscribe(lambda change: heard.append(change.revision))

    def set_both(name: str) -> Callable[[], None]:
        graph.add(name, "object", length=0.0, width=0.0)

        def body() -> None:
            for k in range(1, WRITES + 1):
                graph.set(name, length=float(k), width=float(k))

        return body

    def relate() -> None:
        for _ in range(WRITES):
            graph.relate("R2", "near", "box", distance=1.0)
            graph.unrelate("R2", "near", "box")

    def come_and_go() -> None:
        for k in range(WRITES):
            graph.add("ball", "place", pose=Pose2(float(k), float(k)))
            graph.remove("ball")

    def read() -> None:
        found = graph.attributes("box")
        assert found["length"] == found["width"], "one write was seen in part"
        for node in graph.nodes("place"):
            assert node == "ball"
        assert graph.related("R2", "near") in ([], ["box"])

    def walk() -> None:
        with graph.locked() as view:
            lengths = {n: (row.get("length"), row.get("width")) for n, row in view.nodes(data=True)}
            assert all(a == b for a, b in lengths.values())
            assert view.number_of_edges() <= 1

    writers = [set_both("box"), set_both("wall"), relate, come_and_go]
    begun = graph.revision
    run_together(writers, [read, walk])
    # Two attributes; edge added and removed; node added, its pose, node removed.
    assert graph.revision == begun + WRITES * (2 + 2 + 2 + 3)
    assert heard[-1] == graph.revision
    assert heard == sorted(heard)
    assert len(heard) == len(set(heard))
    emitted = [e.revision for e in sink.events if isinstance(e, KnowledgeChanged)]
    assert emitted == list(range(1, graph.revision + 1))
    assert heard == emitted[1:]
