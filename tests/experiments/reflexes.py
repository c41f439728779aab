"""What the defects of the published reflexes cost, in EXP1: `python -m tests.experiments.reflexes --seeds 60`.

Plays EXP1 with each of four rule files in turn, the same starts and the same R1 for all, and prints the table of
benchmarks/paper/README.md; with `--write` it goes there.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from benchmarks.paper.campaign import Job, play_all
from benchmarks.paper.estimates import mean, share
from rocs_bt import AgentResult
from rocs_bt.compare.statistics import Estimate

REFLEXES = ("braitenberg_published", "braitenberg", "avoid_collision_published", "avoid_collision")
CRUISES = ("0.5 m/s", "0.0975 m/s")  # ours, and the published plan's: 1 rad/s of a wheel of 0.0975 m
PAGE = Path(__file__).resolve().parents[2] / "benchmarks" / "paper" / "README.md"
HEADS = (
    "rules",
    "plan drives at",
    "success",
    "collided",
    "minimum clearance [m]",
    "time to the goal [s]",
    "switches a run",
    "reactive time",
)


def campaign(seeds: Sequence[int], processes: int = 2) -> dict[tuple[str, str], list[AgentResult]]:
    """R2's part of the summaries, by rule file and cruise."""
    cases = [(rules, cruise) for cruise in CRUISES for rules in REFLEXES]
    jobs = [
        Job("exp1", seed, rules=(rules,), parameters=(("cruise", cruise),)) for rules, cruise in cases for seed in seeds
    ]
    found = [summary.agents["R2"] for summary in play_all(jobs, processes=processes)]
    return {case: found[i * len(seeds) : (i + 1) * len(seeds)] for i, case in enumerate(cases)}


def told(found: Estimate, form: str = "{:.2f}") -> str:
    """A number and its interval."""
    value, low, high = (form.format(v) for v in (found.value, found.low, found.high))
    return f"{value} ({low} to {high})"


def row(rules: str, cruise: str, runs: Sequence[AgentResult]) -> tuple[str, ...]:
    """One line of the table."""
    percent = partial(told, form="{:.0%}")
    times = [run.time_to_goal for run in runs if run.outcome == "success"]
    reactive = [r.time_reactive / max(r.time_reactive + r.time_deliberative, 1e-9) for r in runs]
    return (
        f"`{rules}`",
        cruise,
        percent(share(sum(run.outcome == "success" for run in runs), len(runs))),
        percent(share(sum(run.collisions > 0 for run in runs), len(runs))),
        told(mean([run.min_clearance for run in runs]), "{:.3f}"),
        told(mean(times), "{:.1f}") if len(times) > 1 else next((f"{time:.1f}" for time in times), "never"),
        told(mean([float(run.route_switches) for run in runs]), "{:.1f}"),
        percent(mean(reactive)),
    )


def table(seeds: Sequence[int]) -> str:
    """The table, as Markdown."""
    rows = [row(*case, runs) for case, runs in campaign(seeds).items()]
    lines = ["| " + " | ".join(cells) + " |" for cells in (HEADS, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(HEADS), *lines[1:]])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=60)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    made = table(range(1, given.seeds + 1))
    print(made)
    if given.write:
        text = re.sub(r"(?<=reflexes --seeds )\d+", str(given.seeds), PAGE.read_text("utf-8"))
        PAGE.write_text(re.sub(r"\| rules \|.*?(?=\n\n)", lambda _: made, text, flags=re.DOTALL), "utf-8")
