"""Rules: 1 to 1000 rules on one snapshot, relative to hand-written Python and C and other engines; batches, compiling.

CPU time in one process, evaluators alternating. Our rules have hysteresis, hold, cooldown, priority and NaN handling;
the others are stateless (rule_peers.py). Engines that are not installed (extra `bench`) are skipped with a message.
Run it with `python benchmarks rules`.
"""

from __future__ import annotations

import functools
import itertools
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import rule_peers as peers
from row import Row, size
from rule_peers import Evaluator, Floats, Guard

from rocs_bt.actions import ACTIONS
from rocs_bt.base.errors import InputError
from rocs_bt.base.signal import Signal
from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.units import LENGTH
from rocs_bt.base.units import SPEED as SPEED_UNIT
from rocs_bt.expression import Environment
from rocs_bt.reactive import Backend, choose_backend, load_rules
from rocs_bt.reactive.rule import Rule, RuleSet
from rocs_bt.reactive.rule_table import RuleTable, lower_rules

ROUNDS, PERIOD = size(15, 1), 0.05
COUNTS, FILE = size(((1, 10, 100, 1000), 1000), ((1, 10), 10))
TILES, CHUNKS = size((100, 10), (1, 1))  # tiles of 1000 recorded rows
PATIENCE = size(0.05, 0.0001)  # [s] CPU time of an evaluator per round
ENVIRONMENT = Environment.packed(
    [
        Signal("range", peers.RANGES, (LENGTH,), bounds=(0.02, 30.0)),
        Signal("speed", 1, (SPEED_UNIT,), bounds=(-1.0, 1.5)),
        Signal("minima", peers.RANGES - peers.WIDTH + 1, (LENGTH,)),
    ]
)


def run() -> Iterator[Row]:
    """All rows."""
    trace = peers.trace(500)
    for count in COUNTS:
        yield from _snapshot(count, trace)
    yield from _batch(trace)
    yield from _compile()


def _snapshot(count: int, trace: Floats) -> Iterator[Row]:
    """The complete rule set on one snapshot."""
    guards = peers.guards(count)
    table = lower_rules(_rules(guards).rules)
    evaluators = dict(_evaluators(guards, table))
    _agree({name: f for name, f in evaluators.items() if not name.startswith("ours")}, trace)
    micros = _micros(evaluators, trace)
    ratios = {
        "ours, kernel": ("C by hand", 3.0 if count == 100 else None),
        "ours, numpy": ("Python by hand", None),
        "C by hand": ("", None),
        "Python by hand": ("", None),
    }
    for name, value in micros.items():
        baseline, limit = ratios.get(name, ("ours, kernel" if "ours, kernel" in micros else "ours, numpy", None))
        ratio = value / micros[baseline] if baseline in micros else None
        words = "" if limit is None else f"<= {limit:g}x {baseline}"
        holds = None if limit is None or ratio is None else ratio <= limit
        if name == "ours, numpy" and count == 100:
            words, holds = "<= 1 ms", value <= 1e3
        yield Row(f"rules: {count}, {name}", value, "us", baseline, ratio, words, holds)


def _evaluators(guards: list[Guard], table: RuleTable) -> Iterator[tuple[str, Evaluator]]:
    for backend in _backends():
        label = "ours, kernel" if backend.name == "kernel" else "ours, numpy"
        yield label, backend.machine(table).step
    yield "Python by hand", peers.python_by_hand(guards)
    for name, make in {"C by hand": peers.c_by_hand, **peers.PEERS}.items():
        try:
            yield name, make(guards)
        except ImportError as error:
            print(f"  skipped: {name}: {error}", file=sys.stderr)


def _backends() -> Iterator[Backend]:
    yield choose_backend("numpy")
    try:
        yield choose_backend("kernel")
    except InputError as error:
        print(f"  skipped: the kernel: {error}", file=sys.stderr)


def _agree(evaluators: dict[str, Evaluator], trace: Floats) -> None:
    """Check that all evaluators give the same answers."""
    for x in trace[::50]:
        answers = {name: peers.holding(step(x, 0.0)) for name, step in evaluators.items()}
        if len(set(answers.values())) > 1:
            raise RuntimeError(f"the evaluators differ: {answers}")


def _micros(evaluators: dict[str, Evaluator], trace: Floats) -> dict[str, float]:
    """Median CPU time of a call [us], over rounds in which the evaluators alternate."""
    clocks = {name: itertools.count() for name in evaluators}
    x = np.empty(trace.shape[1])
    counts = {}
    for name, step in evaluators.items():
        one = _round(step, trace[:3], x, clocks[name])
        counts[name] = int(np.clip(PATIENCE * 1e6 / max(one, 1e-3), 2, len(trace)))
    rounds: dict[str, list[float]] = {name: [] for name in evaluators}
    for _ in range(ROUNDS):
        for name, step in evaluators.items():
            rows = trace[: counts[name]]
            rounds[name].append(_round(step, rows, x, clocks[name]) - _copying(rows, x))
    return {name: statistics.median(values) for name, values in rounds.items()}


def _round(step: Evaluator, rows: Floats, x: Floats, clock: Iterator[int]) -> float:
    """CPU time of a call [us], including the loop and a copy into the snapshot."""
    start = time.process_time_ns()
    for row, k in zip(rows, clock, strict=False):
        x[:] = row
        step(x, k * PERIOD)
    return (time.process_time_ns() - start) / len(rows) / 1e3


def _copying(rows: Floats, x: Floats) -> float:
    """CPU time of the loop and the copy alone [us]; the call overhead stays with the evaluators."""
    start = time.process_time_ns()
    for row, _ in zip(rows, itertools.count(), strict=False):
        x[:] = row
    return (time.process_time_ns() - start) / len(rows) / 1e3


def _batch(trace: Floats) -> Iterator[Row]:
    """100 rules on a million recorded rows, and on a fleet."""
    table = lower_rules(_rules(peers.guards(100)).rules)
    chunk = np.tile(np.concatenate([trace, trace[::-1]]), (TILES, 1))
    times = np.arange(len(chunk)) * PERIOD
    for backend in _backends():
        limit = 2.0 if backend.name == "kernel" else 8.0
        values, start = table.start(), time.process_time()
        for k in range(CHUNKS):
            backend.batch_time(table, chunk, times + k * (times[-1] + PERIOD), values)
        took = (time.process_time() - start) * 1e6 / (CHUNKS * len(chunk))
        words = f"<= {limit:g} s"
        yield Row(f"rules: 100 on 1e6 recorded rows, {backend.name}", took, "s", "", None, words, took <= limit)
        lanes = chunk[:4096]
        states = table.start(len(lanes))
        tick = _median(functools.partial(backend.batch_lanes, table, lanes, 0.0, states))
        yield Row(f"rules: 100 for {len(lanes)} robots, one tick, {backend.name}", tick * 1e3, "ms")


def _compile() -> Iterator[Row]:
    """Compile typed rules for each back end; read and type them from their file."""
    rules = _rules(peers.guards(FILE)).rules
    took = {b.name: 1e3 * _median(functools.partial(_compiled, b, rules)) for b in _backends()}
    for name, value in took.items():
        limit, holds = ("<= 50 ms", value <= 50.0) if name == "kernel" else ("", None)
        yield Row(f"rules: compile {FILE}, {name}", value, "ms", "", None, limit, holds)
    reading = 1e3 * _median(lambda: _rules(peers.guards(FILE)), 2)
    yield Row(f"rules: read and type {FILE} from their file", reading, "ms")


def _compiled(backend: Backend, rules: Sequence[Rule]) -> None:
    backend.machine(lower_rules(rules))


def _median(call: Callable[[], object], rounds: int = 7) -> float:
    """Median CPU time of a call [s]."""
    times = []
    for _ in range(rounds):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return statistics.median(times)


def _rules(guards: list[Guard]) -> RuleSet:
    return load_rules(read_toml(Path("bench.toml"), peers.rule_file(guards)), ENVIRONMENT, ACTIONS)
