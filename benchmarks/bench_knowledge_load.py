"""What a control loop loses to others at the same Knowledge: a writer at 1 kHz, four readers, and the journal.

The loop works for some 4 ms in each period of 50 ms, in Python that holds the GIL, as a busy agent does. The others
come and go in rounds; what they cost is told by how long the same work takes with them and without, in wall time and in
CPU time of the loop's own thread, by the median of all periods, by the CPU time of the whole process, and by how late
the periods begin and end. On a machine that has other things to do the figures are theirs too. Run it with
`python benchmarks load`.
"""

from __future__ import annotations

import itertools
import random
import resource
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import knowledge_world as world
from row import Row, size

from rocs_bt.geometry import Pose2
from rocs_bt.knowledge import Knowledge
from rocs_bt.knowledge.history import Journal

PERIOD, WORK = 0.05, size(4_000, 100)  # [s]; attributes read in a period, some 4 ms
ROUNDS, PERIODS = size((12, 20), (1, 3))  # of each sort; in a round
WRITES, READS = 1000.0, 100.0  # a second: of the writer, of each of the readers
QUERY = "object where moves and distance(pose, robot) < 2 m order by distance(pose, robot) limit 3"
SWITCH = 0.0005  # [s], as agents in threaded mode have it
BUDGET = 5.0  # [%]


class Period(NamedTuple):
    """One control period: how late it began, how long its work took, the CPU time of that [s], how often it waited."""

    late: float
    took: float
    own: float
    waits: int


def run() -> Iterator[Row]:
    """All rows."""
    known, before = world.known(), sys.getswitchinterval()
    sys.setswitchinterval(SWITCH)
    try:
        with tempfile.TemporaryDirectory() as folder, Journal(Path(folder) / "knowledge.sqlite") as journal:
            journal.attach(known.graph)
            yield from _rows(known)
    finally:
        sys.setswitchinterval(before)


def _rows(known: Knowledge) -> list[Row]:
    go, end = threading.Event(), threading.Event()
    draw, counts = random.Random(5), [0, 0]
    names = itertools.cycle(known.graph.nodes("object"))

    def write() -> None:
        known.graph.set(next(names), pose=Pose2(draw.uniform(0.0, 100.0), draw.uniform(0.0, 100.0)))
        counts[0] += 1

    def read() -> None:
        known.ask(QUERY)
        known.graph.get("o1", "pose")
        counts[1] += 1

    jobs = [(write, 1.0 / WRITES), *[(read, 1.0 / READS)] * 4]
    threads = [threading.Thread(target=_turn, args=(job, every, go, end)) for job, every in jobs]
    for thread in threads:
        thread.start()
    taken: dict[bool, list[Period]] = {False: [], True: []}
    spent = {False: 0.0, True: 0.0}
    try:
        for loaded in [False, True] * ROUNDS:
            (go.set if loaded else go.clear)()
            time.sleep(0.1)  # so that the journal comes to rest
            begin = time.process_time()
            taken[loaded] += _round(known)
            spent[loaded] += time.process_time() - begin
    finally:
        end.set()
        go.set()
        for thread in threads:
            thread.join()
    return [*_costs(taken, spent), *_rates(counts)]


def _rates(counts: list[int]) -> list[Row]:
    seconds = ROUNDS * (PERIODS * PERIOD + 0.1)
    return [
        Row("knowledge: writes a second meanwhile", counts[0] / seconds, "1/s"),
        Row("knowledge: queries a second meanwhile", counts[1] / seconds, "1/s"),
    ]


def _costs(taken: dict[bool, list[Period]], spent: dict[bool, float]) -> list[Row]:
    alone, beside = (statistics.median(period.took for period in taken[loaded]) for loaded in (False, True))
    own, own_beside = (statistics.median(period.own for period in taken[loaded]) for loaded in (False, True))
    lost = 100.0 * (beside - alone) / PERIOD
    share = 100.0 * (spent[True] - spent[False]) / (ROUNDS * PERIODS * PERIOD)
    name = "knowledge: of a control period, lost to 1 kHz writes, 4 readers and the journal"
    rows = [
        Row(name, lost, "%", budget=f"<= {BUDGET:g} %", holds=lost <= BUDGET),
        Row("knowledge: the period's work takes longer by", 100.0 * (beside / alone - 1.0), "%"),
        Row("knowledge: of that, CPU time of its own thread", 100.0 * (own_beside - own) / alone, "%"),
        Row("knowledge: times that a period's work waits for another thread", _mean_waits(taken[True]), "", "", None),
        Row("knowledge: CPU of one core that all of them take, queries included", share, "%"),
    ]
    values: dict[str, Callable[[Period], float]] = {"begins": lambda p: p.late, "ends": lambda p: p.late + p.took}
    for what, value in values.items():
        for percent in (50, 99):
            before, now = (_percentile([value(each) for each in taken[loaded]], percent) for loaded in (False, True))
            words = "alone" if what == "begins" else "alone, its work included"
            rows.append(
                Row(f"knowledge: a period {what} late, p{percent}", 1e3 * now, "ms", words, now / max(before, 1e-9))
            )
    return rows


def _mean_waits(periods: list[Period]) -> float:
    return statistics.mean(period.waits for period in periods)


def _percentile(values: list[float], percent: int) -> float:
    return statistics.quantiles(values, n=100, method="inclusive")[percent - 1]


def _turn(job: Callable[[], None], every: float, go: threading.Event, end: threading.Event) -> None:
    while not end.is_set():
        go.wait()
        due = time.perf_counter()
        while go.is_set() and not end.is_set():
            job()
            due = max(due + every, time.perf_counter() - 10 * every)
            time.sleep(max(0.0, due - time.perf_counter()))


def _round(known: Knowledge) -> list[Period]:
    """Some periods, one after the other."""
    graph, begin, periods = known.graph, time.perf_counter(), []
    for count in range(PERIODS):
        start, own, waits = time.perf_counter(), time.thread_time(), _waits()
        total = 0.0
        for i in range(WORK):
            total += graph.get(f"o{i}", "radius") or 0.0
            total += sum((0.1, 0.2, 0.3, total % 1.0))
        end = time.perf_counter()
        own = time.thread_time() - own
        periods.append(Period(start - begin - count * PERIOD, end - start, own, _waits() - waits))
        time.sleep(max(0.0, begin + (count + 1) * PERIOD - time.perf_counter()))
    return periods


def _waits() -> int:
    """How often this thread gave way of its own: in its work, to wait for the GIL."""
    return resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw
