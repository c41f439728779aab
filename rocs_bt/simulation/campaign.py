"""Many episodes: a scenario over many seeds, in several processes."""

from __future__ import annotations

import dataclasses
import json
import multiprocessing
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..catalog import Catalog
from .run import RECORDING, SUMMARY, run

Summary = dict[str, Any]


@dataclass(frozen=True)
class Job:
    """One episode to be played, in lockstep.

    Attributes:
        scenario: A scenario's name or file.
        seed: Its seed.
        out: A folder for its summary.json; None writes nothing.
        record: Whether run.mcap is written there too.
        rules: The rule files of every agent, in place of the scenario's.
        parameters: More parameters of every agent's mission, as a scenario writes them.
        project: The project in which content is found; None for shipped content.
    """

    scenario: str
    seed: int
    out: Path | None = None
    record: bool = False
    rules: tuple[str, ...] | None = None
    parameters: tuple[tuple[str, Any], ...] = ()
    project: Path | None = None


def play(job: Job) -> Summary:
    """Play one episode; gives its summary.

    Raises:
        InputError: Something in the content is wrong.
        RocsError: The engine failed.
    """
    catalog = Catalog(job.project)
    scenario = catalog.load_scenario(job.scenario)
    agents = tuple(
        dataclasses.replace(
            agent,
            rules=agent.rules if job.rules is None else job.rules,
            parameters={**agent.parameters, **dict(job.parameters)},
        )
        for agent in scenario.agents
    )
    scenario = dataclasses.replace(scenario, agents=agents)
    result = run(scenario, catalog, seed=job.seed, out=job.out if job.record else None, report=False)
    if job.out is not None and not job.record:
        job.out.mkdir(parents=True, exist_ok=True)
        (job.out / RECORDING).unlink(missing_ok=True)  # of an earlier run, which this summary is not of
        (job.out / SUMMARY).write_text(json.dumps(result.summary, indent=2) + "\n", encoding="utf-8")
    return dict(result.summary)


def play_all(
    jobs: Iterable[Job], *, processes: int = 2, progress: Callable[[float], None] = lambda done: None
) -> list[Summary]:
    """Play many episodes, each in one of several processes; gives their summaries in the order of the jobs.

    Args:
        jobs: What to play.
        processes: How many at once.
        progress: Told how many are done.

    Raises:
        RocsError: What the first episode that failed raised; those that wait are not begun.
    """
    todo: Sequence[Job] = list(jobs)
    # Workers are made anew and not forked: physics and solvers bring threads, which a fork would lose.
    pool = ProcessPoolExecutor(processes, mp_context=multiprocessing.get_context("forkserver"))
    try:
        waiting = [pool.submit(play, job) for job in todo]
        for done, future in enumerate(as_completed(waiting), 1):
            future.result()
            progress(done)
        return [future.result() for future in waiting]
    finally:
        pool.shutdown(cancel_futures=True)
