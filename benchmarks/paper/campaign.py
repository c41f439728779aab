"""Campaign: one scenario over many seeds with complete summaries; to compare planners, see `sweep`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rocs_bt import run
from rocs_bt.catalog import CachingCatalog
from rocs_bt.compare.run_sweep import local_pool
from rocs_bt.declare import replaced
from rocs_bt.record import Summary
from rocs_bt.running import RECORDING, SUMMARY


@dataclass(frozen=True)
class Job:
    """One episode to be played in lockstep.

    Attributes:
        scenario: Name or file of a scenario.
        seed: Seed of the episode.
        out: Folder for its summary.json; None to write nothing.
        record: Whether to write run.mcap there too.
        rules: Rule files of every agent, instead of the scenario's.
        parameters: Additional parameters of every agent's mission, as in a scenario file.
        project: Project that contains the content; None for shipped content.
    """

    scenario: str
    seed: int
    out: Path | None = None
    record: bool = False
    rules: tuple[str, ...] | None = None
    parameters: tuple[tuple[str, Any], ...] = ()
    project: Path | None = None


def play(job: Job) -> Summary:
    """Play one episode and return its summary.

    Raises:
        InputError: Content is invalid.
        RocsError: The engine failed.
    """
    catalog = _catalog(job.project)
    scenario = catalog.load_scenario(job.scenario)
    agents = tuple(
        replaced(
            agent,
            rules=agent.rules if job.rules is None else job.rules,
            parameters={**agent.parameters, **dict(job.parameters)},
        )
        for agent in scenario.agents
    )
    scenario = replaced(scenario, agents=agents)
    result = run(scenario, catalog, seed=job.seed, out=job.out if job.record else None, report=False)
    if job.out is not None and not job.record:
        job.out.mkdir(parents=True, exist_ok=True)
        (job.out / RECORDING).unlink(missing_ok=True)  # a recording of an earlier run would not match the summary
        (job.out / SUMMARY).write_text(result.summary.to_json(), encoding="utf-8")
    return result.summary


def play_all(
    jobs: Iterable[Job], *, processes: int = 2, progress: Callable[[float], None] = lambda done: None
) -> list[Summary]:
    """Play many episodes in parallel processes; returns their summaries in the order of the jobs.

    Args:
        jobs: The episodes.
        processes: Number of processes.
        progress: Callback with the number of finished episodes.

    Raises:
        RocsError: Error of the first failed episode; waiting episodes are not started.
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
    """Catalog of this process."""
    return CachingCatalog(project)
