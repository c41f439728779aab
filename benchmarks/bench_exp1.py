"""EXP1 in lockstep: the complete agent with recording, relative to physics, rays and scripted actor alone.

CPU time in one process. The measured loop runs from the first control period to the last: observing and judging,
monitors, reflexes, analysis, the mission's tree, the follower, recording to a file, scripted actor and physics. Time
before the loop (loading, compiling the world) and after it (the recording's index) has a row of its own. Building the
follower's program is not included, since it is cached between runs. Each period's time is its median over several
plays of the same seed, since a shared machine has pauses (periods.py).

The baseline replays the recorded wheel commands: the same world, the same walker, the sonars read at their rate, and
nothing else. Both must give the same trajectory bit by bit, or the benchmark raises. The two alternate seed by seed;
figures are medians over the seeds.

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
from rocs_bt.running import RunResult
from rocs_bt.simulation import build_world

SEEDS = range(1, size(8, 2))
DURATION = size(None, 1.0)  # [s] simulated; None is the scenario's
AGENT, RANGES, WHEELS = "R2", "sonar", "wheels"
PACE, RATIO = 50.0, 3.0


@dataclass(frozen=True)
class Timed:
    """One seed with the complete agent: CPU time of the loop and of the rest [s], number of control periods."""

    loop: float
    rest: float
    periods: int


class Commands:
    """Sink that stores the wheel commands by time."""

    def __init__(self) -> None:
        self.at: dict[float, list[float]] = {}

    def emit(self, event: Event) -> None:
        if type(event) is ActuatorCommanded:
            self.at[event.t] = event.values


def recorded_commands(catalog: Catalog, seed: int) -> tuple[Commands, RunResult]:
    """Wheel commands of the complete agent, and the run's result."""
    commands = Commands()
    return commands, rocs_bt.run("exp1", catalog, seed=seed, duration=DURATION, report=False, sinks=(commands,))


def complete(catalog: Catalog, seed: int, out: Path | None) -> Timed:
    """The complete agent; recorded if `out` is given."""
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
    """Physics, rays and scripted actor alone: CPU time of the loop [s].

    Raises:
        RuntimeError: The trajectory differs from that of the complete agent.
    """
    scenario = catalog.load_scenario("exp1")

    def play(tick: Callable[[float], None]) -> str:
        simulated = build_world(scenario, catalog, seed, NullSink())
        world, every, digest = simulated.world, scenario.rate.control_rate.every, hashlib.sha256()
        sonar, wheels = simulated.sensors[AGENT][RANGES], simulated.actuators[AGENT][WHEELS]
        due = simulated.sensor_rates[AGENT][RANGES].due
        world.digest(digest)
        tick(simulated.clock.now())
        for count in range(periods):
            t = simulated.clock.now()
            if due(count):
                sonar.read()
            if (speeds := commands.at.get(t)) is not None:
                wheels.command(speeds)
            for actor in simulated.actors:
                actor.step(t)
            world.advance(every)
            world.digest(digest)
            tick(t)
        if digest.hexdigest() != expected:
            raise RuntimeError(f"seed {seed}: physics alone gives another trajectory, so the comparison is invalid.")
        return digest.hexdigest()

    return sum(clocked(play))


def measure(catalog: Catalog, folder: Path) -> tuple[list[float], list[Timed], list[Timed], list[float]]:
    """By seed: simulated time [s], recorded, unrecorded, and physics alone."""
    simulated, recorded, plain, bare = [], [], [], []
    for seed in SEEDS:
        commands, result = recorded_commands(catalog, seed)
        simulated.append(result.summary.sim_time)
        plain.append(complete(catalog, seed, None))
        recorded.append(complete(catalog, seed, folder / str(seed)))
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
    what = "physics, rays and scripted actor alone"
    yield Row("EXP1: complete agent, recorded", pace, "x real time", "", None, f">= {PACE:g}x", pace >= PACE)
    yield Row("EXP1: time of the complete agent", each, "us per period", what, ratio, f"<= {RATIO:g}x", ratio <= RATIO)
    yield Row(f"EXP1: {what}", physics, "x real time")
    yield Row("EXP1: time of the complete agent, not recorded", bare_each, "us per period", what, unrecorded)
    yield Row("EXP1: recording", record, "us per period", "the complete agent", record / each)
    yield Row("EXP1: before and after the episode", rest, "ms per run")
