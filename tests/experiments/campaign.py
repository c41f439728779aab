"""EXP1 over many seeds, in lockstep: `python tests/experiments/campaign.py --control 50 --seeds 1 200`.

Prints who reached the goal, who touched what, and the exact (Clopper-Pearson) interval of the share that succeeded.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import multiprocessing
import statistics
import sys
from collections import Counter
from collections.abc import Sequence
from functools import cache
from typing import Any

from rocs_bt.catalog import Catalog, ScenarioSpec
from rocs_bt.event import Event, Touched
from rocs_bt.simulation import run

LIMIT = 60.0  # [s] in which the goal must be reached


class Touches:
    """A sink that counts contacts: by kind, and what was touched."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()

    def emit(self, event: Event) -> None:
        if isinstance(event, Touched):
            self.counts[f"{event.kind} with {event.other}"] += 1


@cache
def variant(control: float) -> tuple[Catalog, ScenarioSpec]:
    """EXP1 with another control rate, which is the sensors' too [1/s]."""
    catalog = Catalog()
    scenario = catalog.load_scenario("exp1")
    rate = dataclasses.replace(scenario.rate, control=control, sensors=control)
    return catalog, dataclasses.replace(scenario, rate=rate)


def episode(seed: int, control: float) -> dict[str, Any]:
    """What came of one seed."""
    catalog, scenario = variant(control)
    touches = Touches()
    summary = run(scenario, catalog, seed=seed, sinks=[touches]).summary
    return {
        "seed": seed,
        "touches": dict(touches.counts),
        "hash": summary["trajectory_hash"],
        **summary["agents"]["R2"],
    }


def campaign(seeds: Sequence[int], control: float, processes: int = 2) -> dict[str, Any]:
    """All seeds, and what they come to.

    A run is a success when its outcome is, in less than 60 s of its own time; a collision of R2 is none.
    """
    with multiprocessing.get_context("forkserver").Pool(processes) as pool:
        runs = pool.starmap(episode, [(seed, control) for seed in seeds], chunksize=4)
    return summed(runs, control)


def summed(runs: Sequence[dict[str, Any]], control: float) -> dict[str, Any]:
    """The figures of some runs."""
    from scipy.stats import binomtest

    good = [r for r in runs if r["outcome"] == "success" and r["time_to_goal"] < LIMIT]
    interval = binomtest(len(good), len(runs)).proportion_ci(method="exact")
    both = [r for r in runs if r["time_reactive"] > 0.0 and r["time_deliberative"] > 0.0]
    touches: Counter[str] = sum((Counter(r["touches"]) for r in runs), Counter())
    return {
        "control": control,
        "runs": len(runs),
        "successes": len(good),
        "interval": [interval.low, interval.high],
        "failed": [{key: r[key] for key in ("seed", "outcome", "reason")} for r in runs if r not in good],
        "touches": dict(sorted(touches.items())),
        "both_routes": len(both),
        "share_reactive": statistics.median(
            r["time_reactive"] / max(r["time_reactive"] + r["time_deliberative"], 1e-9) for r in runs
        ),
        "median_time": statistics.median(r["time_to_goal"] or math.inf for r in runs),
        "least_clearance": min(r["min_clearance"] for r in runs),
    }


def report(found: dict[str, Any]) -> str:
    """The figures in words."""
    low, high = found["interval"]
    lines = [
        f"EXP1, lockstep, control {found['control']:g} Hz: {found['successes']} of {found['runs']} runs reach the goal "
        f"in less than {LIMIT:g} s without a collision: {found['successes'] / found['runs']:.1%}, exact 95 % interval "
        f"{low:.1%} to {high:.1%}",
        f"contacts: {', '.join(f'{n} {kind}' for kind, n in found['touches'].items()) or 'none'}",
        f"both routes in {found['both_routes']} of {found['runs']}; median share of the reactive route "
        f"{found['share_reactive']:.2f}; median time {found['median_time']:.1f} s; least clearance "
        f"{1000.0 * found['least_clearance']:.0f} mm",
    ]
    return "\n".join(lines + [f"seed {r['seed']}: {r['outcome']}, {r['reason']}" for r in found["failed"]])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--control", type=float, default=20.0, help="control and sensor rate [1/s]")
    parser.add_argument("--seeds", type=int, nargs=2, default=(1, 200), help="the first and the last seed")
    parser.add_argument("--json", action="store_true", help="figures for a program")
    given = parser.parse_args()
    found = campaign(range(given.seeds[0], given.seeds[1] + 1), given.control)
    sys.stdout.write((json.dumps(found) if given.json else report(found)) + "\n")


if __name__ == "__main__":
    main()
