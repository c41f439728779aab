"""Cost of storing knowledge and of querying its past: 10,000 nodes, relative to raw networkx, in CPU time.

Run it with `python benchmarks history`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import itertools
import statistics
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import networkx
from row import Row, size

from rocs_bt.base.clock import SimulatedClock, WallClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import NullSink
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import History, Journal

NODES, WRITES, SINGLE = size((10_000, 50_000, 500), (100, 1_000, 5))
SECONDS, READS = size((4.0, 2000), (0.1, 10))
CONTROL = 0.02  # [s] control period, half of which is work


def run() -> Iterator[Row]:
    """All rows."""
    with TemporaryDirectory() as folder:
        yield from _writing(Path(folder))
        yield from _queries(Path(folder))
        yield from _concurrent(Path(folder))


def _graph() -> KnowledgeGraph:
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    for i in range(NODES):
        graph.add(f"o{i}", "object", pose=Pose2(i * 0.1, 1.0), radius=0.2)
        if i:
            graph.relate(f"o{i}", "near", f"o{i - 1}", distance=0.1)
    return graph


_ROUNDS = itertools.count(1)


def _write(graph: KnowledgeGraph, count: int, step: Callable[[], None] = lambda: None) -> None:
    radius = float(next(_ROUNDS))  # a new value, since an equal one is not a change
    for i in range(count):
        graph.set(f"o{i % NODES}", radius=radius + i * 1e-6)
        if i % 100 == 0:
            step()


def _cpu(call: Callable[[], object], clock: Callable[[], int] = time.thread_time_ns) -> float:
    """CPU time of a call [us], of this thread unless another clock is given."""
    begin = clock()
    call()
    return (clock() - begin) / 1e3


def _writing(folder: Path) -> list[Row]:
    graph = _graph()
    plain = statistics.median(_cpu(lambda: _write(graph, NODES)) for _ in range(5)) / NODES
    with Journal(folder / "writing.sqlite", blocking=True, every=60.0) as journal:
        journal.attach(graph)
        rounds, flushes = [], []
        for _ in range(5):
            rounds.append(_cpu(lambda: _write(graph, NODES)) / NODES)
            flushes.append(_cpu(journal.flush) / NODES)
        kept = statistics.median(rounds)
    file, begin = folder / "naive.sqlite", graph.revision
    naive = Journal(file, blocking=True, every=60.0)  # writes that wait for a transaction each
    naive.attach(graph)

    def one_by_one() -> None:
        for i in range(SINGLE):
            graph.set("o1", radius=float(i))
            naive.flush()

    alone = _cpu(one_by_one) / SINGLE
    naive.close()
    assert graph.revision - begin == SINGLE
    return [
        Row("history: checked write, without journal", plain, "us"),
        Row("history: checked write, journal attached (writer's thread)", kept, "us", "without journal", kept / plain),
        Row("history: journal's thread, per change", statistics.median(flushes), "us"),
        Row(
            "history: a write with a transaction of its own", alone, "us", "batched", alone / statistics.median(flushes)
        ),
    ]


def _queries(folder: Path) -> Iterator[Row]:
    graph = _graph()
    clock = graph.clock
    assert isinstance(clock, SimulatedClock)
    raw = networkx.MultiDiGraph(graph.view)
    copy = statistics.median(_cpu(raw.copy) for _ in range(5))
    with Journal(folder / "asking.sqlite", blocking=True) as journal:
        journal.attach(graph)
        _write(graph, WRITES, clock.advance)
    with History(folder / "asking.sqlite") as history:
        for part, words in ((0.0, "at its start"), (0.5, f"{WRITES // 2} changes later")):
            revision = history.first.first + int(part * (history.last.last - history.first.first))
            took = statistics.median(_cpu(lambda r=revision: _first_state(history.path, r)) for _ in range(5))
            name = f"history: file opened, state of all {NODES} nodes, {words}"
            yield Row(name, took / 1e3, "ms", "networkx copy", took / copy)
        took = statistics.median(_cpu(lambda: history.as_of()) for _ in range(5))
        yield Row(f"history: state of all {NODES} nodes, repeated", took / 1e3, "ms", "networkx copy", took / copy)
        history.value("o1", "radius")  # builds the index
        last, end = history.last.last, history.last.end
        turns = itertools.cycle(range(0, NODES, 7))
        for name, when in (("a revision", {"revision": last - WRITES // 2}), ("a time", {"t": end / 2})):
            took = _cpu(lambda w=when: [history.value(f"o{next(turns)}", "radius", **w) for _ in range(READS)]) / READS
            yield Row(f"history: one value as of {name}", took, "us", "networkx copy", took / copy)
        state = history.as_of()
        took = _cpu(lambda: [state.get(f"o{i}", "radius") for i in range(NODES)]) / NODES
        yield Row("history: read an attribute of a state", took, "us")


def _first_state(path: Path, revision: int) -> None:
    with History(path) as history:
        history.as_of(revision=revision)


def _concurrent(folder: Path) -> list[Row]:
    """A control loop alone, and with a 1 kHz writer and four readers at 100 Hz, without and with the journal."""
    graph = KnowledgeGraph(WallClock(), NullSink(), "R2")
    for i in range(100):
        graph.add(f"o{i}", "object", radius=0.2)
    alone = _control()
    begin = graph.revision
    unkept = _beside(graph)
    with Journal(folder / "together.sqlite") as journal:
        journal.attach(graph)
        kept = _beside(graph)
        lost = journal.lost
    rate = (graph.revision - begin) / SECONDS / 2.0
    assert lost == 0
    shares = [100.0 * (each - alone) / SECONDS for each in (kept, kept - unkept + alone)]
    return [
        Row("history: writes per second beside a control loop", rate, "1/s"),
        Row(
            "history: 1 kHz writer, 4 readers, journal: share of one core",
            shares[0],
            "%",
            "",
            None,
            "<= 5 %",
            shares[0] <= 5.0 and rate > 900.0,
        ),
        Row("history: of that, the journal's share", shares[1], "%"),
    ]


def _beside(graph: KnowledgeGraph) -> float:
    """CPU time of the process while a control loop, a writer and readers run [s]."""
    done = threading.Event()

    def every(period: float, call: Callable[[int], object]) -> threading.Thread:
        def go() -> None:
            begin, count = time.monotonic(), 0
            while not done.is_set():
                call(count)
                count += 1
                time.sleep(max(0.0, begin + count * period - time.monotonic()))

        thread = threading.Thread(target=go, daemon=True)
        thread.start()
        return thread

    threads = [every(0.001, lambda n: graph.set(f"o{n % 100}", radius=float(n)))]
    threads += [every(0.01, lambda n: [graph.get(f"o{i}", "radius") for i in range(20)]) for _ in range(4)]
    took = _control()
    done.set()
    for thread in threads:
        thread.join()
    return took


def _control() -> float:
    """CPU time of the process over a fixed number of control periods [s]."""
    begin, count = time.process_time(), 0
    start = time.monotonic()
    for period in range(int(SECONDS / CONTROL)):
        for _ in range(150_000):
            count += 1
        time.sleep(max(0.0, start + (period + 1) * CONTROL - time.monotonic()))
    return time.process_time() - begin
