"""EXP1 with the quadruped: the complete agent with recording, relative to the plant with its inner loop alone.

CPU time in one process, paired, as in bench_exp1.py. The plant is the same world with its gait at each physics step
and the scripted actor, without sensors; it replays the recorded commands. Both must give the same trajectory bit by
bit, or the benchmark raises. Figures are medians over the seeds.

Run it with `python benchmarks quadruped`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import hashlib
import statistics
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from periods import clocked
from row import Row, size

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.event import ActuatorCommanded, Event, NullSink
from rocs_bt.simulation import build_world

SCENARIO, AGENT = "exp1_quadruped", "R2"
SEEDS = range(1, size(5, 2))
DURATION = size(None, 1.0)  # [s] simulated; None is the scenario's
PACE, RATIO = 4.0, 2.0


class Commands:
    """Sink that stores the commands of the gait by time."""

    def __init__(self) -> None:
        self.at: dict[float, list[float]] = {}

    def emit(self, event: Event) -> None:
        if type(event) is ActuatorCommanded:
            self.at[event.t] = event.values


def complete(catalog: Catalog, seed: int, out: Path) -> tuple[float, int, float, str, Commands]:
    """CPU time of the loop [s], number of periods, simulated time [s], trajectory hash and commands."""
    commands, ends = Commands(), list[tuple[float, str]]()

    def play(tick: Callable[[float], None]) -> str:
        result = rocs_bt.run(
            SCENARIO, catalog, seed=seed, duration=DURATION, out=out, report=False, progress=tick, sinks=(commands,)
        )
        ends.append((result.summary.sim_time, str(result.summary.trajectory_hash)))
        return ends[-1][1]

    periods = clocked(play)
    return sum(periods), len(periods), *ends[-1], commands


def alone(catalog: Catalog, seed: int, commands: Commands, periods: int, expected: str) -> float:
    """Plant, gait and scripted actor alone: CPU time of the loop [s].

    Raises:
        RuntimeError: The trajectory differs from that of the complete agent.
    """
    scenario = catalog.load_scenario(SCENARIO)

    def play(tick: Callable[[float], None]) -> str:
        simulated = build_world(scenario, catalog, seed, NullSink())
        world, every, digest = simulated.world, scenario.rate.control_rate.every, hashlib.sha256()
        gait = simulated.actuators[AGENT]["gait"]
        # Past the safety gate: limiting a command again would change its last bits.
        command = gait._device.command
        world.digest(digest)
        tick(simulated.clock.now())
        for _ in range(periods):
            t = simulated.clock.now()
            if (values := commands.at.get(t)) is not None:
                command(values)
            for actor in simulated.actors:
                actor.step(t)
            world.advance(every)
            world.digest(digest)
            tick(t)
        if digest.hexdigest() != expected:
            raise RuntimeError(f"seed {seed}: the plant alone gives another trajectory, so the comparison is invalid.")
        return digest.hexdigest()

    return sum(clocked(play))


def run() -> Iterator[Row]:
    """All rows."""
    catalog, paces, ratios, plants, each = Catalog.here(), list[float](), list[float](), list[float](), list[float]()
    with tempfile.TemporaryDirectory() as folder:
        for seed in SEEDS:
            loop, periods, simulated, expected, commands = complete(catalog, seed, Path(folder) / str(seed))
            plant = alone(catalog, seed, commands, periods, expected)
            paces.append(simulated / loop)
            plants.append(simulated / plant)
            ratios.append(loop / plant)
            each.append(1e6 * loop / periods)
    pace, ratio = statistics.median(paces), statistics.median(ratios)
    what = "plant, gait and scripted actor alone"
    yield Row("quadruped: complete agent, recorded", pace, "x real time", "", None, f">= {PACE:g}x", pace >= PACE)
    time_each = statistics.median(each)
    yield Row(
        "quadruped: time of the complete agent",
        time_each,
        "us per period",
        what,
        ratio,
        f"<= {RATIO:g}x",
        ratio <= RATIO,
    )
    yield Row(f"quadruped: {what}", statistics.median(plants), "x real time")
