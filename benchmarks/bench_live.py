"""The live page: cost for the control loop, on EXP1 in lockstep with a connected browser.

The loop's thread appends each event to a list; the cost is the CPU time of that thread, with and without the page,
alternating. The loop runs at full speed here, so events are faster than in real time, at the same cost each. A second
thread encodes new events ten times per second and holds the interpreter meanwhile. Its CPU time per second of
simulated time is therefore the share that it takes from the loop in real time. The benchmark adds both shares. A
separate process serves the browsers.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator

from row import Row, size

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.record import Recording, RunHeader
from rocs_bt.studio.live import LivePage

SEEDS, ROUNDS = range(1, size(8, 2)), size(3, 1)
DURATION = size(None, 1.0)  # [s] simulated; None is the scenario's
MOST = 0.02
_LISTENS = "import sys, urllib.request\nfor line in urllib.request.urlopen(sys.argv[1] + 'events'): pass"


def header_of(catalog: Catalog) -> RunHeader:
    """Header of the page, taken from a recorded run."""
    with tempfile.TemporaryDirectory() as folder:
        run = rocs_bt.run("exp1", catalog, out=folder, duration=0.1, report=False)
        return Recording.open(run.recording).header


def loop(catalog: Catalog, seed: int, page: LivePage | None) -> tuple[float, float]:
    """CPU time per simulated second of the loop's thread, and of the process's other threads [s]."""
    ticks: list[tuple[float, float]] = []

    def tick(t: float) -> None:
        ticks.append((time.thread_time(), time.process_time()))

    sinks = () if page is None else (page,)
    result = rocs_bt.run("exp1", catalog, seed=seed, duration=DURATION, progress=tick, sinks=sinks)
    own, whole = (ticks[-1][i] - ticks[0][i] for i in (0, 1))
    length = result.summary.sim_time
    return own / length, (whole - own) / length


def measure(catalog: Catalog) -> list[tuple[float, float, float]]:
    """By seed and round: loop without the page, loop with it, encoding thread [s per simulated second]."""
    header, found = header_of(catalog), []
    loop(catalog, 1, None)  # warm-up: builds the follower's program
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


def run() -> Iterator[Row]:
    """All rows."""
    found = measure(Catalog.here())
    without = statistics.median(a for a, _, _ in found)
    append = statistics.median(b / a - 1.0 for a, b, _ in found)
    share = statistics.median(c for _, _, c in found)
    what = "the same loop without it"
    yield Row("live page: EXP1's loop without it", without * 1e3, "ms CPU per simulated second")
    yield Row("live page: additional CPU time of the loop's thread", append * 100, "%", what, 1.0 + append)
    yield Row("live page: encoding thread in real time", share * 100, "% of the time")
    both, allowed = append + share, f"<= {MOST:.0%}"
    yield Row("live page: sum of both", both * 100, "%", what, 1.0 + both, allowed, both <= MOST)
