"""Control period among people, relative to the simulation alone: 720 beams, about 12 tracked movers, plan at 10 Hz.

CPU time in one process. A Jackal drives with the planner `hybrid` through a dense hall in which 14 people walk; a
control period is everything of the agent: monitors, reflexes, tracking, prediction, map, mission, planning in space and
time, follower. The baseline is the rest of the same period in the same play, which a simulation without an agent needs,
too: people, physics, rays of the next scan, outcomes. Each period's time is its median over several plays of the same
seed (periods.py). Periods with fewer than `MOVERS` movers do not count.

Run it with `python benchmarks among`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from typing import Any
from unittest.mock import patch

import numpy as np
from periods import clocked
from row import Row, size

import rocs_bt
from rocs_bt.agent import Agent
from rocs_bt.catalog import Catalog
from rocs_bt.compare.family import load_family

SCENES = range(3240, size(3242, 3241))
DURATION = size(8.0, 1.0)  # [s] simulated
MOVERS = size(10, 0)
MEAN, WORST = 7.0, 15.0  # [ms] budgets


class Periods:
    """CPU time of the agent [s] and number of movers in each control period of a play."""

    def __init__(self) -> None:
        self.agent: list[float] = []
        self.movers: list[int] = []

    def step(self, agent: Agent, *args: Any) -> Any:
        before = time.process_time()
        result = STEP(agent, *args)
        self.agent.append(time.process_time() - before)
        movers = agent.knowledge.world.movers
        self.movers.append(0 if movers is None else len(movers))
        return result


STEP = Agent.step


def played(catalog: Catalog, index: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """By period of a scene: CPU time of the agent and of the whole period [ms], and number of movers."""
    scene = load_family(catalog, "crowd", {"motion": "mixed", "density": "dense"}).scene(index)
    scene = dataclasses.replace(scene, scenario={**scene.scenario, "end_on_collision": False})
    shown = scene.added_to(catalog)
    spec = shown.load_planner("hybrid").drives(shown.load_scenario(scene.name), "R", scene.privileged)
    plays: list[Periods] = []

    def play(tick: Callable[[float], None]) -> str:
        plays.append(periods := Periods())
        with patch.object(Agent, "step", lambda agent, *args: periods.step(agent, *args)):
            result = rocs_bt.run(spec, shown, seed=1, duration=DURATION, report=False, progress=tick)
        return str(result.summary.trajectory_hash)

    whole = np.array(clocked(play))
    agent = np.median([periods.agent for periods in plays], axis=0)
    count = min(len(whole), len(agent))
    first = size(10, 1)  # set-up, and the first tracks
    return 1e3 * agent[first:count], 1e3 * whole[first:count], np.array(plays[0].movers)[first:count]


def run() -> Iterator[Row]:
    """The rows of this benchmark."""
    catalog = Catalog.here()
    agent, whole, movers = (np.concatenate(part) for part in zip(*(played(catalog, i) for i in SCENES), strict=True))
    chosen = movers >= MOVERS
    agent, rest = agent[chosen], whole[chosen] - agent[chosen]
    mean, worst = float(agent.mean()), float(np.percentile(agent, 99))
    what = f"control period among {movers[chosen].mean():.0f} movers"
    baseline = "simulation of the period alone"
    yield Row(f"{what}, mean", mean, "ms", baseline, mean / float(rest.mean()), f"<= {MEAN:g} ms", mean <= MEAN)
    yield Row(f"{what}, 99 %", worst, "ms", baseline, worst / float(rest.mean()), f"<= {WORST:g} ms", worst <= WORST)
