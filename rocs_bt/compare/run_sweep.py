"""Sweep: play every planner in every scene with every seed, each episode once."""

from __future__ import annotations

import os
from collections.abc import Callable, Container, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, replace

from ..base.errors import Fault, InputError, RocsError
from ..catalog import Catalog, PlannerSpec
from .check_planners import check_planners
from .episode import Episode, ScenarioScene, SceneRef
from .key import EpisodeKeys
from .pool import EXIT_TIMEOUT, WorkerDied, WorkerPool
from .record import EpisodeRecord
from .runner import failure_record, run_episode
from .store import Cost, EpisodeStore

WALL_LIMIT = 300.0
"""Maximum wall-clock time of an episode [s]."""

_AHEAD = 4  # queued tasks per worker: enough to keep workers busy without holding 10,000 episodes in memory


@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """Options of a sweep.

    Attributes:
        workers: Number of local processes; None for one per core.
        wall_limit: Maximum wall-clock time of an episode [s]. A process that exceeds it is ended, and the episode has
            the outcome `limit`, which is a failure.
        retry_errors: Whether to play episodes again that ended in `error` or `limit` in an earlier sweep.
        require: Additional requirement on the agents, such as `always min(front) > 0.05 m`; it changes the keys of the
            episodes.
        stop_when: Function called after each scene, in scene order, with all episodes so far; the sweep ends if it
            returns True. When it ends does not depend on the speed of the workers, so the result is reproducible.
        warned: Function called before the first episode with the warnings of the check.
    """

    workers: int | None = None
    wall_limit: float = WALL_LIMIT
    retry_errors: bool = False
    require: str = ""
    stop_when: Callable[[Sequence[EpisodeRecord]], bool] | None = None
    warned: Callable[[Sequence[Fault]], None] = lambda warnings: None


@dataclass(frozen=True)
class Sweep:
    """Result of a sweep."""

    store: EpisodeStore
    keys: tuple[str, ...]  # ordered by planner, scene and seed
    played: int  # the other episodes were in the store already
    warnings: tuple[Fault, ...] = ()

    def records(self) -> Iterator[EpisodeRecord]:
        """Episodes in the order of the keys."""
        return self.store.records(self.keys)


def sweep(
    planners: Sequence[PlannerSpec | str],
    scenes: Iterable[SceneRef | str],
    seeds: Iterable[int] = (1,),
    *,
    catalog: Catalog | None = None,
    store: EpisodeStore | None = None,
    executor: Executor | None = None,
    options: SweepOptions | None = None,
    progress: Callable[[float], None] = lambda done: None,
) -> Sweep:
    """Play every planner in every scene with every seed, except episodes that are in the store already.

    Every result is stored as soon as it arrives. A sweep that was killed therefore continues where it ended when it is
    called again. Before it plays an episode, each planner is checked in each scenario, and in a scene of each family.

    Args:
        planners: Planners, or their names.
        scenes: Scenes, or names of scenarios.
        seeds: Seeds of each scene.
        catalog: Source of content; the project around the current folder by default.
        store: Store of episodes; in memory by default.
        executor: Executor of the episodes, such as `dask.distributed.Client(...).get_executor()`; local processes by
            default.
        options: Options.
        progress: Callback with the number of finished episodes.

    Raises:
        InputError: Content is invalid: `rocs-bt check` finds errors, or a scene cannot be played; finished episodes are
            in the store.
        RocsError: The executor failed.
    """
    catalog, options = catalog or Catalog.here(), options or SweepOptions()
    chosen = [catalog.load_planner(each) if isinstance(each, str) else each for each in planners]
    refs = [ScenarioScene(scene) if isinstance(scene, str) else scene for scene in scenes]
    store, warnings = EpisodeStore() if store is None else store, tuple[Fault, ...]()
    try:
        by_scene = episodes_of(chosen, refs, tuple(seeds), catalog, options)
    except InputError:
        check_planners(chosen, refs, catalog)  # finds the same, and all other errors
        raise
    if not all(store.outcome(episode.key) for episodes in by_scene for episode in episodes):
        warnings = check_planners(chosen, refs, catalog)
        options.warned(warnings)
    found = play_episodes(by_scene, store, executor, options, progress)
    return replace(found, warnings=warnings)


def play_episodes(
    by_scene: Sequence[Sequence[Episode]],
    store: EpisodeStore,
    executor: Executor | None,
    options: SweepOptions,
    progress: Callable[[float], None] = lambda done: None,
) -> Sweep:
    """Play the episodes of a sweep, grouped by scene, without a check; see `sweep`."""
    again = ("", "error", "limit") if options.retry_errors else ("",)
    done = {episode.key for episodes in by_scene for episode in episodes if store.outcome(episode.key) not in again}
    scene_progress = _Progress(by_scene, store, options.stop_when)
    found = len(done)
    progress(found)
    if not scene_progress.complete(done):
        with ExitStack() as stack:
            todo = [episode for episodes in by_scene for episode in episodes if episode.key not in done]
            if executor is None:
                executor = stack.enter_context(local_pool(min(options.workers or cores(), len(todo))))
            for record, cost in stack.enter_context(closing(_play(executor, iter(todo)))):
                store.put(record, cost)
                done.add(record.key)
                progress(len(done))
                if scene_progress.complete(done):
                    break
    return Sweep(store, scene_progress.keys, len(done) - found)


def episodes_of(
    planners: Sequence[PlannerSpec],
    scenes: Iterable[SceneRef],
    seeds: Sequence[int],
    catalog: Catalog,
    options: SweepOptions,
) -> list[list[Episode]]:
    """All episodes of a sweep, grouped by scene, because workers cache the scenes that they have prepared."""
    _refuse_duplicate_names(planners)
    keys, extra = EpisodeKeys(catalog), (catalog.project, options.wall_limit, options.require, catalog.code)
    return [
        [Episode(keys.of(p, scene, seed, options.require), p, scene, seed, *extra) for p in planners for seed in seeds]
        for scene in scenes
    ]


class _Progress:
    """Progress of a sweep in finished scenes, and the decision when the sweep ends."""

    def __init__(
        self,
        by_scene: Sequence[Sequence[Episode]],
        store: EpisodeStore,
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
        """Keys of the episodes of finished scenes, ordered by planner, scene and seed."""
        episodes = [episode for episodes in self._by_scene[: self._scenes] for episode in episodes]
        order = {name: i for i, name in enumerate(dict.fromkeys(episode.planner.name for episode in episodes))}
        return tuple(episode.key for episode in sorted(episodes, key=lambda episode: order[episode.planner.name]))

    def complete(self, done: Container[str]) -> bool:
        """Whether the sweep ends, because all scenes are finished or `stop_when` has returned True."""
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
    """Context of a pool of local worker processes, which are killed at the end of the `with` block."""
    pool = WorkerPool(workers)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def cores() -> int:
    """Number of cores available to this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _play(executor: Executor, episodes: Iterator[Episode]) -> Generator[tuple[EpisodeRecord, Cost], None, None]:
    """Play episodes with a bounded queue; yields record and cost of each in the order of completion.

    If a process died, the time limit of its episode is known only from a finished one of the family. The record
    therefore follows that one, or is the last.
    """
    ahead = _AHEAD * int(getattr(executor, "workers", 0) or getattr(executor, "_max_workers", 0) or 16)
    waiting: dict[Future[tuple[EpisodeRecord, Cost]], Episode] = {}
    limits: dict[str, float] = {}  # time limits by family, from finished episodes
    died: list[tuple[Episode, Exception]] = []
    try:
        while True:
            while len(waiting) < ahead and (episode := next(episodes, None)) is not None:
                waiting[executor.submit(run_episode, episode)] = episode
            if not waiting:
                break
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                episode = waiting.pop(future)
                played = _result(future)
                if isinstance(played, Exception):
                    died.append((episode, played))
                else:
                    limits.setdefault(played[0].family, played[0].time_limit)
                    yield played
            for each in [each for each in died if each[0].scene.group in limits]:
                died.remove(each)
                yield _died(*each, limits[each[0].scene.group]), Cost(0.0, 0.0)
        for episode, error in died:
            yield _died(episode, error, 0.0), Cost(0.0, 0.0)
    finally:
        for future in waiting:
            future.cancel()


def _result(future: Future[tuple[EpisodeRecord, Cost]]) -> tuple[EpisodeRecord, Cost] | Exception:
    """Record and cost of a played episode, or the exception that reports the death of its process."""
    try:
        return future.result()
    except InputError:
        raise
    except (BrokenExecutor, CancelledError) as error:
        raise RocsError(f"the executor failed: {type(error).__name__}: {error}") from error
    except Exception as error:  # noqa: BLE001 - executors report a dead worker with different exceptions
        return error


def _died(episode: Episode, error: Exception, time_limit: float) -> EpisodeRecord:
    """Record of an episode after its process died: with the outcome `limit` after its wall limit, else `error`."""
    if isinstance(error, WorkerDied) and error.exit_code == EXIT_TIMEOUT:
        reason = f"it took longer than the wall limit of {episode.wall_limit:g} s"
        return failure_record(episode, "limit", reason, time_limit, reproducible=False)
    return failure_record(episode, "error", _reason(error), time_limit, reproducible=False)


def _reason(error: Exception) -> str:
    return str(error) if isinstance(error, RocsError) else f"{type(error).__name__}: {error}"


def _refuse_duplicate_names(planners: Sequence[PlannerSpec]) -> None:
    names = [planner.name for planner in planners]
    if duplicates := sorted({name for name in names if names.count(name) > 1}):
        raise InputError(f"two planners are named '{duplicates[0]}'. Results are reported by name: rename one.")
