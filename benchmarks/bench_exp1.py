"""EXP1 in lockstep: the whole stack with its recording, beside the same physics, rays and mover alone.

CPU time in one process. What counts is the episode's loop, from its first control period to its last: observing and
judging, monitors, reflexes, analysis, the mission's tree, the follower, recording to a file, mover and physics. What
comes before (loading, compiling the world) and after (the recording's index) is a row of its own;
the follower's program is kept from run to run, so its building is in none. Each period's time is its median over
several plays of the same seed, since a shared machine stops now and then (periods.py).

The other side of the comparison plays the commands that the whole stack gave: the same world, the same walker, the
sonars read at their rate, and nothing else. Both must come to the same trajectory, bit by bit, or nothing is printed.
The two take turns, seed by seed; figures are medians over the seeds.

Run it with `python benchmarks exp1`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import hashlib
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from periods import clocked
from row import Row, size

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.event import ActuatorCommanded, Event, NullSink
from rocs_bt.simulation import RunResult, build_world

SEEDS = range(1, size(8, 2))
DURATION = size(None, 1.0)  # [s] simulated; None is the scenario's
AGENT, RANGES, WHEELS = "R2", "sonar", "wheels"
PACE, RATIO = 50.0, 3.0


@dataclass(frozen=True)
class Timed:
    """One seed, whole: CPU time of its loop and of everything else [s], and its control periods."""

    loop: float
    rest: float
    periods: int


class Commands:
    """A sink that keeps the wheel commands, by time."""

    def __init__(self) -> None:
        self.at: dict[float, list[float]] = {}

    def emit(self, event: Event) -> None:
        if type(event) is ActuatorCommanded:
            self.at[event.t] = event.values


def heard(catalog: Catalog, seed: int) -> tuple[Commands, RunResult]:
    """The wheel commands that the whole stack gives, and what came of them."""
    commands = Commands()
    return commands, rocs_bt.run("exp1", catalog, seed=seed, duration=DURATION, report=False, sinks=(commands,))


def whole(catalog: Catalog, seed: int, out: Path | None) -> Timed:
    """The whole stack; recorded where `out` is given."""
    rests: list[float] = []

    def play(tick: Callable[[float], None]) -> str:
        marks = [time.process_time()]

        def marked(t: float) -> None:
            tick(t)
            marks.append(time.process_time())

        result = rocs_bt.run("exp1", catalog, seed=seed, duration=DURATION, out=out, report=False, progress=marked)
        rests.append(marks[1] - marks[0] + time.process_time() - marks[-1])
        return str(result.summary.trajectory_hash)

    periods = clocked(play)
    return Timed(sum(periods), statistics.median(rests), len(periods))


def alone(catalog: Catalog, seed: int, commands: Commands, periods: int, expected: str) -> float:
    """Physics, rays and mover alone: CPU time of the loop [s].

    Raises:
        RuntimeError: They came to another trajectory than the whole stack.
    """
    scenario = catalog.load_scenario("exp1")

    def play(tick: Callable[[float], None]) -> str:
        stage = build_world(scenario, catalog, seed, NullSink())
        world, every, digest = stage.world, scenario.rate.control_rate.every, hashlib.sha256()
        sonar, wheels = stage.sensors[AGENT][RANGES], stage.actuators[AGENT][WHEELS]
        due = stage.sensor_rates[AGENT][RANGES].due
        world.digest(digest)
        tick(stage.clock.now())
        for count in range(periods):
            t = stage.clock.now()
            if due(count):
                sonar.read()
            if (speeds := commands.at.get(t)) is not None:
                wheels.command(speeds)
            for mover in stage.movers:
                mover.step(t)
            world.advance(every)
            world.digest(digest)
            tick(t)
        if digest.hexdigest() != expected:
            raise RuntimeError(f"seed {seed}: physics alone came to another trajectory; the comparison means nothing.")
        return digest.hexdigest()

    return sum(clocked(play))


def measure(catalog: Catalog, folder: Path) -> tuple[list[float], list[Timed], list[Timed], list[float]]:
    """By seed: simulated time [s]; recorded, not recorded, and physics alone."""
    simulated, recorded, plain, bare = [], [], [], []
    for seed in SEEDS:
        commands, result = heard(catalog, seed)
        simulated.append(result.summary.sim_time)
        plain.append(whole(catalog, seed, None))
        recorded.append(whole(catalog, seed, folder / str(seed)))
        bare.append(alone(catalog, seed, commands, recorded[-1].periods, result.summary.trajectory_hash))
    return simulated, recorded, plain, bare


def run() -> Iterator[Row]:
    """All rows."""
    catalog = Catalog.here()
    with tempfile.TemporaryDirectory() as folder:
        simulated, recorded, plain, bare = measure(catalog, Path(folder))
    median: Callable[..., float] = statistics.median
    pace = median(t / r.loop for t, r in zip(simulated, recorded, strict=True))
    physics = median(t / s for t, s in zip(simulated, bare, strict=True))
    ratio = median(r.loop / s for r, s in zip(recorded, bare, strict=True))
    each = median(r.loop / r.periods for r in recorded) * 1e6
    unrecorded = median(p.loop / s for p, s in zip(plain, bare, strict=True))
    bare_each = median(p.loop / p.periods for p in plain) * 1e6
    record = median((r.loop - p.loop) / r.periods for r, p in zip(recorded, plain, strict=True)) * 1e6
    rest = median(r.rest for r in recorded) * 1e3
    what = "physics, rays and mover alone"
    yield Row("EXP1: whole stack, recorded", pace, "x real time", "", None, f">= {PACE:g}x", pace >= PACE)
    yield Row("EXP1: time of the whole stack", each, "us a period", what, ratio, f"<= {RATIO:g}x", ratio <= RATIO)
    yield Row(f"EXP1: {what}", physics, "x real time")
    yield Row("EXP1: time of the whole stack, not recorded", bare_each, "us a period", what, unrecorded)
    yield Row("EXP1: recording", record, "us a period", "the whole stack", record / each)
    yield Row("EXP1: before and after the episode", rest, "ms a run")
