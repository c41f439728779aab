"""Slow-down of a control loop by other users of the same Knowledge: a writer at 1 kHz and four readers.

The loop works for about 4 ms in each period of 50 ms, in Python that holds the GIL, like a busy agent. Rounds with and
without the other threads alternate. The cost is the difference in the work's duration: wall time, CPU time of the
loop's thread (medians over all periods), CPU time of the process, and the lateness of the start and end of periods.
Other load on the machine affects the figures. Run it with `python benchmarks load`.
"""

from __future__ import annotations

import itertools
import random
import resource
import statistics
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import knowledge_world as world
from row import Row, size

from rocs_bt.base.geometry import Pose2
from rocs_bt.knowledge import Knowledge

PERIOD, WORK = 0.05, size(4_000, 100)  # [s]; attributes read in a period, some 4 ms
ROUNDS, PERIODS = size((12, 20), (1, 3))  # rounds of each kind; periods in a round
WRITES, READS = 1000.0, 100.0  # [1/s] rate of the writer, rate of each reader
QUERY = "object where moves and distance(pose, robot) < 2 m order by distance(pose, robot) limit 3"
SWITCH = 0.0005  # [s], as agents in threaded mode have it
BUDGET = 5.0  # [%]


class Period(NamedTuple):
    """One control period: lateness of its start, duration and CPU time of its work [s], number of waits."""

    late: float
    took: float
    own: float
    waits: int


def run() -> Iterator[Row]:
    """All rows."""
    known, before = world.known(), sys.getswitchinterval()
    sys.setswitchinterval(SWITCH)
    try:
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
            time.sleep(0.1)  # lets the others become idle
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
        Row("knowledge: writes per second under load", counts[0] / seconds, "1/s"),
        Row("knowledge: queries per second under load", counts[1] / seconds, "1/s"),
    ]


def _costs(taken: dict[bool, list[Period]], spent: dict[bool, float]) -> list[Row]:
    alone, beside = (statistics.median(period.took for period in taken[loaded]) for loaded in (False, True))
    own, own_beside = (statistics.median(period.own for period in taken[loaded]) for loaded in (False, True))
    lost = 100.0 * (beside - alone) / PERIOD
    share = 100.0 * (spent[True] - spent[False]) / (ROUNDS * PERIODS * PERIOD)
    name = "knowledge: share of a control period lost to 1 kHz writes, 4 readers"
    rows = [
        Row(name, lost, "%", budget=f"<= {BUDGET:g} %", holds=lost <= BUDGET),
        Row("knowledge: increase of the work's duration", 100.0 * (beside / alone - 1.0), "%"),
        Row("knowledge: of that, CPU time of the loop's thread", 100.0 * (own_beside - own) / alone, "%"),
        Row("knowledge: waits for another thread, per period", _mean_waits(taken[True]), "", "", None),
        Row("knowledge: CPU time of all other threads, share of one core", share, "%"),
    ]
    values: dict[str, Callable[[Period], float]] = {"start": lambda p: p.late, "end": lambda p: p.late + p.took}
    for what, value in values.items():
        for percent in (50, 99):
            before, now = (_percentile([value(each) for each in taken[loaded]], percent) for loaded in (False, True))
            words = "alone" if what == "start" else "alone, its work included"
            rows.append(
                Row(
                    f"knowledge: lateness of a period's {what}, p{percent}",
                    1e3 * now,
                    "ms",
                    words,
                    now / max(before, 1e-9),
                )
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
    """Some consecutive periods."""
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
    """Voluntary context switches of this thread: during its work, waits for the GIL."""
    return resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw
