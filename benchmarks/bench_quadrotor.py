"""EXP1 on the quadrotor in lockstep: the complete agent, recorded, relative to the plant with its inner loop alone.

As `bench_exp1.py`, with the scenario `exp1_quadrotor`. The baseline repeats the calls of the flight controller, with
physics, the inner loop at 200 Hz and the scripted actor, without any sensor. Its trajectory must be the same, bitwise.

Run it with `python benchmarks quadrotor`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import hashlib
import statistics
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from periods import clocked
from row import Row, size

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.event import NullSink
from rocs_bt.interfaces.device import Actuator
from rocs_bt.simulation import SimulatedWorld, build_world

SCENARIO, AGENT, MOTION = "exp1_quadrotor", "R2", "rotors"
SEEDS = range(1, size(6, 2))
DURATION = size(None, 2.0)  # [s] simulated; None is the scenario's
PACE, RATIO = 8.0, 2.5


class Logged(Actuator):
    """Driver whose calls are stored by time; None is `neutral`."""

    def __init__(self, device: Actuator, now: Callable[[], float]) -> None:
        super().__init__(device.name, device.size)
        self.device, self.now = device, now
        self.calls: dict[float, list[list[float] | None]] = {}

    def command(self, values: Sequence[float]) -> None:
        self.calls.setdefault(self.now(), []).append(list(values))
        self.device.command(values)

    def neutral(self) -> None:
        self.calls.setdefault(self.now(), []).append(None)
        self.device.neutral()


def logged(simulated: SimulatedWorld) -> Logged:
    """Wrap the flight controller of a world."""
    made: list[Logged] = []

    def make(device: Actuator) -> Actuator:
        made.append(Logged(device, simulated.clock.now))
        return made[-1]

    simulated.actuators[AGENT][MOTION].wrap(make)
    return made[0]


def complete(catalog: Catalog, seed: int, out: Path) -> tuple[float, int, str, float]:
    """The complete agent: CPU time of the loop [s], control periods, trajectory hash and simulated time [s]."""
    found: list[tuple[str, float]] = []

    def play(tick: Callable[[float], None]) -> str:
        summary = rocs_bt.run(
            SCENARIO, catalog, seed=seed, duration=DURATION, out=out, report=False, progress=tick
        ).summary
        found.append((str(summary.trajectory_hash), summary.sim_time))
        return found[-1][0]

    periods = clocked(play)
    return sum(periods), len(periods), *found[-1]


def plant(catalog: Catalog, seed: int, calls: dict[float, list[list[float] | None]], periods: int, due: str) -> float:
    """The plant with its inner loop and the scripted actor: CPU time of the loop [s].

    Raises:
        RuntimeError: The trajectory is not the due one.
    """
    scenario = catalog.load_scenario(SCENARIO)

    def play(tick: Callable[[float], None]) -> str:
        simulated = build_world(scenario, catalog, seed, NullSink())
        world, digest, device = simulated.world, hashlib.sha256(), logged(simulated).device
        world.digest(digest)
        tick(simulated.clock.now())
        for _ in range(periods):
            t = simulated.clock.now()
            for values in calls.get(t, ()):
                if values is None:
                    device.neutral()
                else:
                    device.command(values)
            for actor in simulated.actors:
                actor.step(t)
            world.advance(scenario.rate.control_rate.every)
            world.digest(digest)
            tick(t)
        if digest.hexdigest() != due:
            raise RuntimeError(f"seed {seed}: the plant alone gives another trajectory, so the comparison is invalid.")
        return digest.hexdigest()

    return sum(clocked(play))


def measure(catalog: Catalog, seed: int, out: Path) -> tuple[float, float, float]:
    """Time of the complete agent and of the plant alone [s], and simulated time [s]."""
    wrapped: list[Logged] = []
    rocs_bt.run(
        SCENARIO,
        catalog,
        seed=seed,
        duration=DURATION,
        report=False,
        prepare=lambda world: wrapped.append(logged(world)),
    )
    loop, periods, due, simulated = complete(catalog, seed, out)
    return loop, plant(catalog, seed, wrapped[0].calls, periods, due), simulated


def run() -> Iterator[Row]:
    """All rows."""
    catalog = Catalog.here()
    with tempfile.TemporaryDirectory() as folder:
        measured = [measure(catalog, seed, Path(folder) / str(seed)) for seed in SEEDS]
    pace = statistics.median(simulated / loop for loop, _, simulated in measured)
    bare = statistics.median(simulated / alone for _, alone, simulated in measured)
    ratio = statistics.median(loop / alone for loop, alone, _ in measured)
    what = "the plant with its inner loop alone"
    yield Row("EXP1 on the quadrotor: complete agent, recorded", pace, "x real time", "", None, ">= 8x", pace >= PACE)
    yield Row(f"EXP1 on the quadrotor: {what}", bare, "x real time", what, ratio, "<= 2.5x", ratio <= RATIO)
