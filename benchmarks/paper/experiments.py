"""EXP1 to EXP3 over many seeds: data of the paper's figures (paper, 6.3 to 6.5)."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rocs_bt.base.errors import RocsError
from rocs_bt.compare.statistics import Estimate
from rocs_bt.record import AgentResult, Recording, Summary

from .campaign import Job, play, play_all
from .estimates import mean, share
from .page import Experiment, write_paper

EXPERIMENTS = ("exp1", "exp2", "exp3")
NUMBERS = "figures.json"


@dataclass(frozen=True)
class Numbers:
    """Results of one agent over many runs of one experiment.

    Attributes:
        success: Share of successful runs.
        collided: Share of runs in which the agent collided.
        struck: Share of runs in which another object struck the agent while it was stationary.
        reactive: Mean share of the driving time in which reflexes controlled the wheels.
        switches: Mean number of route switches per minute [1/min].
        distance_error: Mean error of the follow distance [m]; None for an agent that follows no robot.
    """

    success: Estimate
    collided: Estimate
    struck: Estimate
    reactive: Estimate
    switches: Estimate
    distance_error: Estimate | None


def make_paper(
    out: Path, *, seeds: int = 50, processes: int = 2, progress: Callable[[float], None] = lambda done: None
) -> list[Path]:
    """Run the experiments and write the paper's figures, the page and the numbers.

    Files below `out`: `paper.html`, `figure-*.svg|pdf|png`, `figures.json`, and `runs/<experiment>-<seed>/summary.json`
    of every run; drawn runs also have their recording there.

    Args:
        out: Output folder; created if missing.
        seeds: Number of runs per experiment, with seeds 1, 2, ...
        processes: Number of parallel processes.
        progress: Callback with the number of finished runs, of 3 x `seeds`.

    Returns:
        The page, then the figures.

    Raises:
        RocsError: A run failed, or is not reproducible.
    """
    jobs = [Job(name, seed, out / "runs" / f"{name}-{seed}") for name in EXPERIMENTS for seed in range(1, seeds + 1)]
    summaries = play_all(jobs, processes=processes, progress=progress)
    experiments, data = [], {}
    for name in EXPERIMENTS:
        runs = [s for s in summaries if s.scenario == name]
        numbers = {agent: numbers_of(runs, agent) for agent in runs[0].agents}
        data[name] = {agent: _plain(asdict(found)) for agent, found in numbers.items()}
        run, among = typical(runs)
        experiments.append(
            Experiment(
                scenario=name,
                recording=_drawn(run, out),
                chosen=_chosen(run, among),
                captions={agent: captions(found) for agent, found in numbers.items()},
            )
        )
    out.mkdir(parents=True, exist_ok=True)
    (out / NUMBERS).write_text(
        json.dumps({"seeds": seeds, "experiments": data}, indent=2, allow_nan=False) + "\n", encoding="utf-8"
    )
    command = f"python -m benchmarks.paper --seeds {seeds}"
    return write_paper(experiments, out, seeds=seeds, command=command)


def numbers_of(runs: Sequence[Summary], agent: str) -> Numbers:
    """Results of one agent over some runs of one experiment."""
    mine = [run.agents[agent] for run in runs]
    found = [m.following.distance_error for m in mine if m.following is not None]
    errors = [error for error in found if error is not None]
    return Numbers(
        success=share(sum(m.outcome == "success" for m in mine), len(mine)),
        collided=share(sum((m.collisions or 0) > 0 for m in mine), len(mine)),
        struck=share(sum((m.struck or 0) > 0 for m in mine), len(mine)),
        reactive=mean([_reactive(m) for m in mine]),
        switches=mean([60.0 * m.route_switches / run.sim_time for m, run in zip(mine, runs, strict=True)]),
        distance_error=mean(errors) if errors else None,
    )


def typical(runs: Sequence[Summary]) -> tuple[Summary, str]:
    """Run to draw: the one with the median number of switches in the first nonempty of these sets.

    Runs in which all agents succeed and both routes act in each; those in which both routes act in at least one; all
    runs. Ties go to the lower seed.

    Returns:
        The run, and a text that names the set.
    """
    good = [run for run in runs if all(agent.outcome == "success" for agent in run.agents.values())]
    sets = (
        (
            [r for r in good if all(map(_switched, r.agents.values()))],
            "that succeed with both routes active in each robot",
        ),
        ([r for r in good if any(map(_switched, r.agents.values()))], "that succeed with a reflex"),
        (runs, "of this experiment"),
    )
    among, words = next((found, words) for found, words in sets if found)
    ordered = sorted(among, key=lambda run: (_switches(run), run.seed))
    return ordered[(len(ordered) - 1) // 2], f"of the runs {words} ({len(among)})"


def captions(found: Numbers) -> list[tuple[str, str]]:
    """Rows of a caption: labels and texts."""
    error = found.distance_error
    return [
        ("success", _percent(found.success)),
        ("collided", _percent(found.collided)),
        ("struck while stationary", _percent(found.struck)),
        ("reactive time", _percent(found.reactive, counted=False)),
        ("switches per minute", f"{found.switches.value:.2f} ({_ends(found.switches, '{:.2f}')})"),
        ("follow-distance error", "does not follow" if error is None else _metres(error)),
    ]


def _drawn(summary: Summary, out: Path) -> Recording:
    """Recording of a run, which is played again and must be identical."""
    folder = out / "runs" / f"{summary.scenario}-{summary.seed}"
    again = play(Job(summary.scenario, summary.seed, folder, record=True))
    if again.trajectory_hash != summary.trajectory_hash:
        raise RocsError(f"{summary.scenario} with seed {summary.seed} is not reproducible: its trajectory differs.")
    return Recording.open(folder)


def _chosen(run: Summary, among: str) -> str:
    texts = []
    for name, agent in run.agents.items():
        when = "" if agent.time_to_goal is None else f" after {agent.time_to_goal:.1f} s"
        switches = agent.route_switches
        texts.append(f"{name}: {agent.outcome}{when}, {switches} switch{'' if switches == 1 else 'es'} of route")
    return f"Seed {run.seed}: {among} it has the median number of switches. {'; '.join(texts)}."


def _reactive(agent: AgentResult) -> float:
    driven: float = agent.time_reactive + agent.time_deliberative
    return agent.time_reactive / driven if driven > 0.0 else 0.0


def _switched(agent: AgentResult) -> bool:
    return bool(agent.route_switches)


def _switches(run: Summary) -> int:
    return sum(agent.route_switches for agent in run.agents.values())


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    """Values for JSON; NaN, such as an undefined end of an interval, becomes None."""
    return {
        key: _plain(value) if isinstance(value, dict) else None if value != value else value
        for key, value in values.items()
    }


def _percent(found: Estimate, *, counted: bool = True) -> str:
    count = f"{round(found.value * found.of)} of {found.of}, " if counted else ""
    low, high = (f"{100.0 * end:.1f}" for end in (found.low, found.high))
    return f"{count}{100.0 * found.value:.1f}\u00a0% ({low} to {high}\u00a0%)"


def _metres(found: Estimate) -> str:
    return f"{found.value:.3f}\u00a0m ({_ends(found, '{:.3f}')}\u00a0m)"


def _ends(found: Estimate, form: str) -> str:
    return " to ".join("–" if math.isnan(end) else form.format(end) for end in (found.low, found.high))
