"""Cost of sharing for the control loop: the loop in lockstep, and reflex latency while another process floods.

Run it with `python benchmarks share_loop`, or all benchmarks with `make bench`. The reflex is that of bench_reflex. The
flood comes over zenoh on loopback from a process that sends as fast as it can: messages, requests for all knowledge,
writes that are refused, and unauthenticated frames.
"""

from __future__ import annotations

import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from bench_reflex import measure
from bench_share import _addresses
from row import Row, size

from rocs_bt import run as play
from rocs_bt.catalog import Catalog
from rocs_bt.knowledge import Knowledge
from rocs_bt.share.replica import Entry
from rocs_bt.share.scope import SharingScope
from rocs_bt.share.sharing import Sharing
from rocs_bt.share.wire import Delta, Request, TextMessage, encode
from rocs_bt.share.zenoh_network import ZenohNetwork

SEEDS = size((1, 2, 3), (1,))
SECONDS = size(20.0, 0.5)  # simulated time
CROSSINGS = size(60, 1)


def run() -> Iterator[Row]:
    """All rows."""
    yield from _lockstep()
    yield from _reflex()


# -- in lockstep ------------------------------------------------------------------------------------------------------


def _lockstep() -> list[Row]:
    """EXP3: both robots see each other, so that they behave the same with and without sharing."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "scenarios").mkdir()
        for name, table in (("alone", ""), ("together", '[share]\nkinds = ["peer"]\n')):
            text = f'format = "scenario/2"\nbase = "exp3"\n{table}'
            (Path(folder) / "scenarios" / f"{name}.toml").write_text(text, "utf-8")
        catalog = Catalog(Path(folder))
        ratios, shares = [], []
        for seed in SEEDS:
            alone, _ = _cpu(catalog, "alone", seed)
            together, turns = _cpu(catalog, "together", seed)
            ratios.append(together / alone)
            shares.append(100.0 * turns / together)
    name = f"EXP3 in lockstep, {len(SEEDS)} seeds of {SECONDS:g} s"
    return [
        Row(
            f"{name}: CPU time with sharing",
            statistics.median(ratios),
            "x",
            "without sharing",
            statistics.median(ratios),
        ),
        Row(f"{name}: share of sharing cycles, both robots", statistics.median(shares), "%"),
    ]


def _cpu(catalog: Catalog, scenario: str, seed: int) -> tuple[float, float]:
    """CPU time of a run and of its sharing cycles [s]."""
    turns, turn = [0.0], Sharing.run

    def timed(sharing: Sharing, t: float) -> None:
        start = time.thread_time()
        turn(sharing, t)
        turns[0] += time.thread_time() - start

    Sharing.run = timed
    try:
        start = time.process_time()
        play(scenario, catalog, seed=seed, duration=SECONDS, report=False)
        return time.process_time() - start, turns[0]
    finally:
        Sharing.run = turn


# -- on wall time -----------------------------------------------------------------------------------------------------


def _reflex() -> Iterator[Row]:
    counts: Mapping[str, int] = {}
    for what, goal in (
        ("no sharing", None),
        ("no sharing, another process is busy", "burn"),
        ("sharing, another process is busy", "beside"),
        ("sharing, another process floods it", "flood"),
    ):
        here, there = _addresses(2)
        sharing: list[Sharing] = []
        with _other(goal, there, here):
            join = None if goal in (None, "burn") else _join(here, sharing)
            found = sorted(measure(burn=0.0, plan=10.0, crossings=CROSSINGS, share=join))
        name = f"reflex, threaded, {what}, {CROSSINGS} crossings"
        yield Row(f"{name}: p50", statistics.median(found), "ms")
        yield Row(f"{name}: p99", found[math.ceil(0.99 * len(found)) - 1], "ms")
        counts = sharing[0].counts.as_dict() if sharing else counts
    bad = sum(counts[reason] for reason in ("oversized", "unauthenticated", "malformed", "flooded", "refused"))
    yield Row("received frames of the flood", counts["frames"], "")
    yield Row("rejected", bad, "")


def _join(listen: str, found: list[Sharing]) -> Callable[[Knowledge], Sharing]:
    def join(knowledge: Knowledge) -> Sharing:
        scope, origin = SharingScope(knowledge.graph.schema), f"{knowledge.agent}#{os.urandom(8).hex()}"
        network = ZenohNetwork(listen)
        found.append(Sharing(knowledge, scope, network, origin=origin, calendar=time.time))
        return found[0]

    return join


@contextmanager
def _other(what: str | None, listen: str, peer: str) -> Iterator[None]:
    """A second process during the block, which keeps a core busy or floods."""
    if what is None:
        yield
        return
    other = subprocess.Popen([sys.executable, __file__, what, listen, peer])
    try:
        yield
    finally:
        other.kill()
        other.wait()


def _flood(what: str, listen: str, peer: str) -> None:
    """Create frames endlessly, and send them if wanted."""
    network = ZenohNetwork(listen, [peer] if what == "flood" else [])
    origin = f"M#{os.urandom(8).hex()}"
    link = network.join(origin, lambda frame: None, lambda peer: None)
    number = 0
    while True:
        number += 1
        bad = [Entry((f"box {i}", "object", "radius"), -1.0, 10**15, origin, number + i) for i in range(300)]
        delta = Delta(number, 0, 1, "", {}, {}, bad, [0.0] * len(bad))
        for message in (TextMessage(number, "x" * 1000), Request({}), delta):
            link.send(encode(origin, message, b""))
        for length in (100, 60000):
            link.send(bytes(length))


if __name__ == "__main__":
    _flood(*sys.argv[1:])
