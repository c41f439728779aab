"""The live page: what it costs the control loop, on EXP1 in lockstep with a browser that listens.

The loop's thread pays for one list append an event; that is measured as CPU time of that thread, with and without the
page, the two taking turns. It runs at full speed here, so events come faster than at a robot's pace; the cost of each
is the same. One more thread encodes what came ten times a second. It holds the interpreter while it does, so its CPU
time for a second of the run's own time is the share that it takes from the loop at a robot's pace. The two shares are
added. Whatever browsers ask for is done in another process.

Run it with `python benchmarks/bench_live.py`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time

from row import Row

from rocs_bt import simulation
from rocs_bt.catalog import Catalog
from rocs_bt.event import NullSink
from rocs_bt.record import RunHeader
from rocs_bt.record.live import LivePage
from rocs_bt.simulation import set_stage
from rocs_bt.simulation.header import make_header
from rocs_bt.simulation.run import stage_minds

SEEDS = range(1, 8)
ROUNDS = 3
MOST = 0.02
_LISTENS = "import sys, urllib.request\nfor line in urllib.request.urlopen(sys.argv[1] + 'events'): pass"


def header_of(catalog: Catalog) -> RunHeader:
    """What a page is told before the run."""
    scenario = catalog.load_scenario("exp1")
    stage = set_stage(scenario, catalog, 1, NullSink())
    agents = stage_minds(scenario, stage, catalog, NullSink())
    return make_header(scenario, stage, agents, seed=1, mode="lockstep", content_hash="")


def loop(catalog: Catalog, seed: int, page: LivePage | None) -> tuple[float, float]:
    """CPU time of the loop's thread a simulated second, and that of the process's other threads [s]."""
    ticks: list[tuple[float, float]] = []

    def tick(t: float) -> None:
        ticks.append((time.thread_time(), time.process_time()))

    sinks = () if page is None else (page,)
    result = simulation.run("exp1", catalog, seed=seed, progress=tick, sinks=sinks)
    own, whole = (ticks[-1][i] - ticks[0][i] for i in (0, 1))
    length = result.summary["sim_time"]
    return own / length, (whole - own) / length


def measure(catalog: Catalog) -> list[tuple[float, float, float]]:
    """By seed and round: the loop without the page, with it, and the encoding thread [s a simulated second]."""
    header, found = header_of(catalog), []
    loop(catalog, 1, None)  # the follower's program is built once
    for _ in range(ROUNDS):
        for seed in SEEDS:
            with LivePage() as page:
                page.begin(header)
                browser = subprocess.Popen([sys.executable, "-c", _LISTENS, page.url])
                time.sleep(0.5)
                turns = [None, page] if seed % 2 else [page, None]
                times = {turn is not None: loop(catalog, seed, turn) for turn in turns}
                found.append((times[False][0], times[True][0], max(0.0, times[True][1] - times[False][1])))
            browser.wait()
    return found


def run() -> list[Row]:
    """All rows."""
    found = measure(Catalog.here())
    without = statistics.median(a for a, _, _ in found)
    append = statistics.median(b / a - 1.0 for a, b, _ in found)
    share = statistics.median(c for _, _, c in found)
    what = "the same loop without it"
    return [
        Row("live page: EXP1's loop without it", without * 1e3, "ms CPU a simulated second"),
        Row("live page: more CPU time of the loop's thread", append * 100, "%", what, 1.0 + append),
        Row("live page: its encoding thread at a robot's pace", share * 100, "% of the time"),
        Row("live page: both", (append + share) * 100, "%", what, 1 + append + share, f"<= {MOST:.0%}",
            append + share <= MOST),
    ]  # fmt: skip


if __name__ == "__main__":
    for row in run():
        print(row)
