"""The experiments over many seeds, in lockstep: `python tests/experiments/campaign.py exp3 --seeds 101 200`.

`--robot` plays an experiment with another robot: `campaign.py exp1 --robot rosbot_xl` is `exp1_mecanum`.

Prints for each agent its outcomes, contacts, and, for a follower, how it kept its distance; each share has an exact
(Clopper-Pearson) 95 % interval. The requirements on a follower come from its parameters in the scenario: its band is
`distance` +- (`distance` - `safety`), and it never drives nearer than `safety`.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
from collections import Counter
from collections.abc import Sequence
from functools import cache
from typing import Any

from rocs_bt import run
from rocs_bt.catalog import CachingCatalog, ScenarioSpec
from rocs_bt.compare.run_sweep import local_pool
from rocs_bt.declare import replaced

SHARES = ("success", "clean", "clean_with_reflex", "collided", "fell", "struck")
"""Printed shares of the runs; `clean_with_reflex` of those in which a reflex was active."""


@cache
def variant(experiment: str, control: float, robot: str | None) -> tuple[CachingCatalog, ScenarioSpec]:
    """An experiment with another control rate, which is the sensors' too [1/s], and with another first robot."""
    catalog = CachingCatalog()
    scenario = catalog.load_scenario(experiment)
    if robot is not None:
        agents = (replaced(scenario.agents[0], robot=robot), *scenario.agents[1:])
        scenario = replaced(scenario, agents=agents)
    if control == scenario.rate.control:
        return catalog, scenario
    rate = replaced(scenario.rate, control=control, sensors=control)
    return catalog, replaced(scenario, rate=rate)


def episode(experiment: str, seed: int, control: float, robot: str | None = None) -> dict[str, Any]:
    """Summary of one seed."""
    catalog, scenario = variant(experiment, control, robot)
    return json.loads(run(scenario, catalog, seed=seed).summary.to_json())


def campaign(
    experiment: str, seeds: Sequence[int], control: float, processes: int = 2, robot: str | None = None
) -> dict[str, Any]:
    """Play all seeds; figures of each agent."""
    with local_pool(processes) as pool:
        jobs = [pool.submit(episode, experiment, seed, control, robot) for seed in seeds]
        runs = [future.result() for future in jobs]
    agents = {name: summed(experiment, name, runs) for name in runs[0]["agents"]}
    setting = {"experiment": experiment, "robot": robot, "control": control, "seeds": [seeds[0], seeds[-1]]}
    return {**setting, "agents": agents}


def share(count: int, of: int) -> dict[str, Any]:
    """A share with its exact 95 % interval."""
    from scipy.stats import binomtest

    interval = binomtest(count, of).proportion_ci(method="exact") if of else None
    return {"count": count, "of": of, "interval": [interval.low, interval.high] if interval else [0.0, 1.0]}


def summed(experiment: str, name: str, runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Figures of one agent.

    In EXP1 a success is one in less than the scenario's duration; the other experiments end by their own clock. A
    clean run is a success without a collision and without a fall.
    """
    mine = [{"seed": r["seed"], **r["agents"][name]} for r in runs]
    exp1 = experiment.partition("_")[0] == "exp1"
    limit = CachingCatalog().load_scenario(experiment).duration if exp1 else math.inf
    good = [r for r in mine if r["outcome"] == "success" and (r["time_to_goal"] or 0.0) < limit]

    def clean(r: dict[str, Any]) -> bool:
        return r in good and not r["collisions"] and not r["fell"]

    touches: Counter[str] = Counter()
    for r in mine:
        touches.update({f"{kind} with {o}": n for kind, counts in r["contacts"].items() for o, n in counts.items()})
    spent = [(r["time_reactive"], r["time_deliberative"]) for r in mine]
    found = {
        "success": share(len(good), len(mine)),
        "clean": share(sum(map(clean, mine)), len(mine)),
        "fell": share(sum(r["fell"] for r in mine), len(mine)),
        "collided": share(sum(r["collisions"] > 0 for r in mine), len(mine)),
        "struck": share(sum(r["struck"] > 0 for r in mine), len(mine)),
        "touches": dict(sorted(touches.items())),
        "both_routes": sum(min(both) > 0.0 for both in spent),
        "clean_with_reflex": share(
            sum(clean(r) for r in mine if r["reflex_activations"]), sum(r["reflex_activations"] > 0 for r in mine)
        ),
        "share_reactive": statistics.median(a / max(a + b, 1e-9) for a, b in spent),
        "median_time": statistics.median(r["time_to_goal"] or math.inf for r in mine),
        "least_clearance": min(r["min_clearance"] for r in mine),
        "goals": dict(sorted(Counter(r["goals_reached"] for r in mine).items())),
        "failed": [{key: r[key] for key in ("seed", "outcome", "reason")} for r in mine if r not in good],
    }
    follows = [(r["seed"], r["following"]) for r in mine if r["following"] is not None]
    lost = [r["localisation"] for r in mine if r["localisation"] is not None]
    return found | ({"following": followed(follows)} if follows else {}) | ({"estimate": erred(lost)} if lost else {})


def erred(runs: Sequence[dict[str, float]]) -> dict[str, Any]:
    """Errors of the estimates [m, rad]: mean of each figure over the runs, and the greatest of all runs."""
    mean = {key: statistics.fmean(r[key] for r in runs) for key in runs[0]}
    return {"mean": mean, "greatest": {key: max(r[key] for r in runs) for key in ("position_max", "heading_max")}}


def followed(follows: Sequence[tuple[int, dict[str, Any]]]) -> dict[str, Any]:
    """Distances of a follower over all runs."""
    caught_up = [(seed, found) for seed, found in follows if found["periods"]]
    periods = sum(found["periods"] for _, found in caught_up)
    under = [seed for seed, found in follows if not found["safe"]]
    return {
        "in_band": sum(found["in_band"] * found["periods"] for _, found in caught_up) / periods,
        "too_far": sum(found["too_far"] * found["periods"] for _, found in caught_up) / periods,
        "worst": sorted((found["in_band"], seed) for seed, found in caught_up)[:6],
        "mean": statistics.fmean(found["mean_distance"] for _, found in caught_up),
        "error": statistics.fmean(found["distance_error"] for _, found in caught_up),
        "least": min(found["least_distance"] for _, found in caught_up),
        "least_driving": min(
            (f["least_driving"] for _, f in follows if f["least_driving"] is not None), default=math.inf
        ),
        "below_safety_driving": {**share(len(under), len(follows)), "seeds": under},
    }


def _words(found: dict[str, Any]) -> str:
    low, high = found["interval"]
    return f"{found['count']} of {found['of']} (exact 95 % interval {low:.1%} to {high:.1%})"


def report(found: dict[str, Any]) -> str:
    """The figures in words."""
    first, last = found["seeds"]
    played = f"{found['experiment']}{f' with {robot}' if (robot := found['robot']) else ''}"
    lines = [f"{played}, lockstep, control {found['control']:g} Hz, seeds {first} to {last}"]
    for name, agent in found["agents"].items():
        lines += [f"{name} {what.replace('_', ' ')}: {_words(agent[what])}" for what in SHARES]
        lines.append(f"  contacts: {', '.join(f'{n} {kind}' for kind, n in agent['touches'].items()) or 'none'}")
        lines.append(
            f"  goals reached: {agent['goals']}; both routes in {agent['both_routes']}; median share of the reactive "
            f"route {agent['share_reactive']:.2f}; median time {agent['median_time']:.1f} s; minimum clearance "
            f"{1000.0 * agent['least_clearance']:.0f} mm"
        )
        if follow := agent.get("following"):
            lines.append(
                f"  in its band {follow['in_band']:.1%} of the following time, too far {follow['too_far']:.1%}; mean "
                f"distance {follow['mean']:.2f} m, mean error {follow['error']:.2f} m; least {follow['least']:.2f} m, "
                f"while driving {follow['least_driving']:.2f} m"
            )
            under = follow["below_safety_driving"]
            lines.append(f"  below the safety distance while driving: {_words(under)} {under['seeds']}")
            lines.append(f"  worst: {', '.join(f'seed {seed} {kept:.0%}' for kept, seed in follow['worst'])}")
        if off := agent.get("estimate"):
            mean, greatest = off["mean"], off["greatest"]
            lines.append(
                f"  estimate, means over the runs: {100.0 * mean['position_rms']:.1f} cm rms, at most "
                f"{100.0 * mean['position_max']:.1f} cm; {math.degrees(mean['heading_rms']):.1f} deg rms, at most "
                f"{math.degrees(mean['heading_max']):.1f} deg; NEES over 3 {mean['nees']:.2f}; at most in all runs "
                f"{100.0 * greatest['position_max']:.1f} cm, {math.degrees(greatest['heading_max']):.1f} deg"
            )
        lines += [f"  seed {r['seed']}: {r['outcome']}, {r['reason']}" for r in agent["failed"]]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("experiment", nargs="?", default="exp1", help="exp1, exp2 or exp3, or a scenario's file")
    parser.add_argument("--robot", help="robot of the first agent, instead of the scenario's")
    parser.add_argument("--control", type=float, default=20.0, help="control and sensor rate [1/s]")
    parser.add_argument("--seeds", type=int, nargs=2, default=(1, 200), help="the first and the last seed")
    parser.add_argument("--json", action="store_true", help="figures for a program")
    given = parser.parse_args()
    seeds = range(given.seeds[0], given.seeds[1] + 1)
    found = campaign(given.experiment, seeds, given.control, robot=given.robot)
    sys.stdout.write((json.dumps(found) if given.json else report(found)) + "\n")


if __name__ == "__main__":
    main()
