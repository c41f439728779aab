"""A sweep: every planner in every scene with every seed, each episode played once for good."""

from __future__ import annotations

import os
from collections.abc import Callable, Container, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass

from ..catalog import Catalog, PlannerSpec, at_parameters
from ..errors import InputError, RocsError
from ..plan import mission_arguments
from .episode import Episode, ScenarioScene, SceneRef
from .key import Keys
from .pool import EXIT_TIMEOUT, WorkerDied, WorkerPool
from .record import EpisodeRecord
from .runner import error_record, run_episode
from .store import Cost, Store

WALL_LIMIT = 300.0
"""How long an episode may take to compute [s]."""

_AHEAD = 4  # tasks that wait for each worker: enough to keep it busy, few enough to hold 10,000 episodes in no memory


@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """How a sweep is played.

    Attributes:
        workers: Number of local processes; None for one for each core.
        wall_limit: Longest time to compute an episode [s]; then its process is ended, and it is tried once more.
        retry_errors: Whether to play again what ended in `error` before.
        require: One more requirement on the agents; such episodes are others than those without.
        enough: Asked after each scene, in their order, with all episodes so far: True ends the sweep there. It is the
            same scene however fast who plays what, so a sweep that ends early repeats too.
    """

    workers: int | None = None
    wall_limit: float = WALL_LIMIT
    retry_errors: bool = False
    require: str = ""
    stop_when: Callable[[Sequence[EpisodeRecord]], bool] | None = None


@dataclass(frozen=True)
class Sweep:
    """What a sweep came to.

    Attributes:
        store: Where its episodes are.
        keys: Theirs, by planner, then by scene, then by seed.
        played: How many were played now; the others stood in the store.
    """

    store: Store
    keys: tuple[str, ...]
    played: int

    def records(self) -> Iterator[EpisodeRecord]:
        """The episodes, in the order of the keys."""
        return self.store.records(self.keys)


def sweep(
    planners: Sequence[PlannerSpec | str],
    scenes: Iterable[SceneRef | str],
    seeds: Iterable[int] = (1,),
    *,
    catalog: Catalog | None = None,
    store: Store | None = None,
    executor: Executor | None = None,
    options: SweepOptions | None = None,
    progress: Callable[[float], None] = lambda done: None,
) -> Sweep:
    """Play every planner in every scene with every seed, but for what the store has already.

    Killed at any moment and called again, it goes on where it was. Everything that comes back is written at once.

    Args:
        planners: Planners, or their names.
        scenes: Scenes, or names of scenarios.
        seeds: The seeds of each scene.
        catalog: Where content is found; the project around the current folder by default.
        store: Where episodes are kept; in memory by default.
        executor: Who plays them, such as `dask.distributed.Client(...).get_executor()`; local processes by default.
        options: How they are played.
        progress: Told how many of the episodes are there.

    Raises:
        InputError: Content is wrong; what was played so far is in the store.
        RocsError: The executor broke down.
    """
    catalog, options = catalog or Catalog.here(), options or SweepOptions()
    store = Store() if store is None else store
    by_scene = _by_scene(planners, scenes, tuple(seeds), catalog, options)
    again = ("", "error") if options.retry_errors else ("",)
    done = {episode.key for episodes in by_scene for episode in episodes if store.outcome(episode.key) not in again}
    finished = _Progress(by_scene, store, options.stop_when)
    found = len(done)
    progress(found)
    if not finished.over(done):
        with ExitStack() as stack:
            todo = [episode for episodes in by_scene for episode in episodes if episode.key not in done]
            if executor is None:
                executor = stack.enter_context(local_pool(min(options.workers or cores(), len(todo))))
            for record, cost in stack.enter_context(closing(_play(executor, iter(todo)))):
                store.put(record, cost)
                done.add(record.key)
                progress(len(done))
                if finished.over(done):
                    break
    return Sweep(store, finished.keys, len(done) - found)


def _by_scene(
    planners: Sequence[PlannerSpec | str],
    scenes: Iterable[SceneRef | str],
    seeds: Sequence[int],
    catalog: Catalog,
    options: SweepOptions,
) -> list[list[Episode]]:
    """All trials scene by scene, since a worker keeps the scene that it has set up."""
    chosen = [catalog.load_planner(p) if isinstance(p, str) else p for p in planners]
    _refuse_duplicate_names(chosen)
    for planner in chosen:
        _refuse_wrong_parameters(planner, catalog)
    refs = [ScenarioScene(scene) if isinstance(scene, str) else scene for scene in scenes]
    keys, extra = Keys(catalog), (catalog.project, options.wall_limit, options.require, catalog.code)
    return [
        [Episode(keys.of(p, scene, seed, options.require), p, scene, seed, *extra) for p in chosen for seed in seeds]
        for scene in refs
    ]


class _Progress:
    """How far a sweep has come, scene by scene."""

    def __init__(
        self,
        by_scene: Sequence[Sequence[Episode]],
        store: Store,
        stop_when: Callable[[Sequence[EpisodeRecord]], bool] | None,
    ) -> None:
        self._by_scene = by_scene
        self._store = store
        self._stop_when = stop_when
        self._records: list[EpisodeRecord] = []
        self._scenes = 0
        self._ended = False

    @property
    def keys(self) -> tuple[str, ...]:
        """Of the scenes that count: by planner, then by scene, then by seed."""
        episodes = [episode for episodes in self._by_scene[: self._scenes] for episode in episodes]
        order = {name: i for i, name in enumerate(dict.fromkeys(episode.planner.name for episode in episodes))}
        return tuple(episode.key for episode in sorted(episodes, key=lambda episode: order[episode.planner.name]))

    def over(self, done: Container[str]) -> bool:
        """Whether all scenes are played, or enough of them."""
        while not self._ended and self._scenes < len(self._by_scene):
            keys = [episode.key for episode in self._by_scene[self._scenes]]
            if not all(key in done for key in keys):
                return False
            self._scenes += 1
            if self._stop_when is not None:
                self._records += self._store.records(keys)
                self._ended = self._stop_when(self._records)
        return True


@contextmanager
def local_pool(workers: int) -> Iterator[WorkerPool]:
    """Local processes, which are ended with the block, whatever they are at."""
    pool = WorkerPool(workers)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _play(executor: Executor, episodes: Iterator[Episode]) -> Generator[tuple[EpisodeRecord, Cost], None, None]:
    """Play trials in any order, a few ahead of what is done."""
    ahead = _AHEAD * int(getattr(executor, "workers", 0) or getattr(executor, "_max_workers", 0) or 16)
    waiting: dict[Future[tuple[EpisodeRecord, Cost]], Episode] = {}
    limits: dict[str, float] = {}  # by family, as the episodes tell that came to an end
    try:
        while True:
            while len(waiting) < ahead and (episode := next(episodes, None)) is not None:
                waiting[executor.submit(run_episode, episode)] = episode
            if not waiting:
                return
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                episode = waiting.pop(future)
                record, cost = _result(future, episode, limits.get(episode.scene.group, 0.0))
                limits.setdefault(record.family, record.time_limit)
                yield record, cost
    finally:
        for future in waiting:
            future.cancel()


def _result(
    future: Future[tuple[EpisodeRecord, Cost]], episode: Episode, time_limit: float
) -> tuple[EpisodeRecord, Cost]:
    """What became of a trial; one whose process died, however often it was tried, is an error for the record.

    Raises:
        InputError: Content is wrong.
        RocsError: The executor broke down.
    """
    try:
        return future.result()
    except InputError:
        raise
    except (BrokenExecutor, CancelledError) as error:
        raise RocsError(f"the executor broke down: {type(error).__name__}: {error}") from error
    except Exception as error:  # noqa: BLE001 - every executor has its own word for a worker that died
        late = isinstance(error, WorkerDied) and error.exit_code == EXIT_TIMEOUT
        reason = f"it took longer than the wall limit of {episode.wall_limit:g} s" if late else _reason(error)
        return error_record(episode, reason, time_limit, reproducible=False), Cost(0.0, 0.0)


def _reason(error: Exception) -> str:
    return str(error) if isinstance(error, RocsError) else f"{type(error).__name__}: {error}"


def _refuse_wrong_parameters(planner: PlannerSpec, catalog: Catalog) -> None:
    """Before a worker does, which knows the scene's file only."""
    try:
        mission_arguments(catalog.load_mission(planner.mission, planner.nodes), planner.parameters)
    except InputError as error:
        raise at_parameters(planner, error) from error


def _refuse_duplicate_names(planners: Sequence[PlannerSpec]) -> None:
    names = [planner.name for planner in planners]
    if duplicates := sorted({name for name in names if names.count(name) > 1}):
        raise InputError(f"two planners are named '{duplicates[0]}'. Give each its own name, under which it is told.")
