"""A campaign: one scenario over many seeds, each with its whole summary; to compare planners, see `sweep`."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rocs_bt import run
from rocs_bt.catalog import CachingCatalog
from rocs_bt.compare.run_sweep import local_pool
from rocs_bt.record import Summary
from rocs_bt.simulation import RECORDING, SUMMARY


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
    catalog = _catalog(job.project)
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
        (job.out / SUMMARY).write_text(result.summary.to_json(), encoding="utf-8")
    return result.summary


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
    with local_pool(min(processes, len(todo))) as pool:
        waiting = [pool.submit(play, job) for job in todo]
        for done, future in enumerate(as_completed(waiting), 1):
            future.result()
            progress(done)
        return [future.result() for future in waiting]


@lru_cache(maxsize=1)
def _catalog(project: Path | None) -> CachingCatalog:
    """This process's catalog."""
    return CachingCatalog(project)
