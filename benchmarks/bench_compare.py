"""Sweeps: episodes per second, overhead of store and engine, speed-up of two workers, memory.

EXP1 with the planner `tree`, without recording, and scenes of barn_like with `hybrid` and its lidar. The episode time
is the CPU time of `EpisodeRunner.play` in this process, including the preparation of scenes. The overhead is the rest
of a sweep's CPU time in this process: keys, messages, the store. The speed-up of two workers is wall time, so it is
meaningful only on an idle machine with two cores. Memory is the growth of this process over a sweep of very short
episodes, per 1,000 episodes.

Run it with `python benchmarks compare`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future
from pathlib import Path

from row import Row, size

from rocs_bt.catalog import Catalog
from rocs_bt.compare import EpisodeStore, ScenarioScene, SweepOptions, scenes_of, sweep
from rocs_bt.compare.episode import Episode, SceneRef
from rocs_bt.compare.run_sweep import cores
from rocs_bt.compare.runner import EpisodeRunner

SEEDS = range(1, size(25, 2))
FIELDS, FIELD_SEEDS = size((8, (1, 2)), (1, (1,)))
MANY, WORKERS = size((1000, None), (10, 1))  # episodes; None for a worker on each core


class InProcessExecutor(Executor):
    """Executor that runs tasks in this process."""

    workers = 1

    def submit(self, fn, /, *args, **kwargs):
        future: Future = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def episode_time(name: str, scenes: Sequence[SceneRef], seeds: Sequence[int]) -> float:
    """CPU time per episode of a planner [s]."""
    runner, planner = EpisodeRunner(), Catalog().load_planner(name)
    episodes = [Episode("", planner, scene, seed) for scene in scenes for seed in seeds]
    runner.play(episodes[0])  # warm-up: one-time loading
    begun = time.process_time()
    for episode in episodes:
        runner.play(episode)
    return (time.process_time() - begun) / len(episodes)


def sweep_times() -> tuple[float, float]:
    """CPU time per episode of a sweep in this process: in total, and for playing only [s]."""
    catalog = Catalog()
    with tempfile.TemporaryDirectory() as folder, EpisodeStore(Path(folder)) as store:
        sweep(["tree"], ["exp1"], [0], catalog=catalog, store=store, executor=InProcessExecutor())
        begun = time.process_time()
        found = sweep(["tree"], ["exp1"], SEEDS, catalog=catalog, store=store, executor=InProcessExecutor())
        spent = time.process_time() - begun
        return spent / found.played, store.cost(found.keys).cpu / found.played


def rate(workers: int) -> float:
    """Episodes per second of wall time with some workers, after a warm-up."""
    marks: list[tuple[float, float]] = []
    with tempfile.TemporaryDirectory() as folder, EpisodeStore(Path(folder)) as store:
        sweep(
            ["tree"],
            ["exp1"],
            range(1, 1 + 4 * len(SEEDS)),
            catalog=Catalog(),
            store=store,
            options=SweepOptions(workers=workers),
            progress=lambda done: marks.append((time.perf_counter(), done)),
        )
    warm = [mark for mark in marks if mark[1] >= len(SEEDS)]
    (begun, first), (ended, last) = warm[0], warm[-1]
    return (last - first) / (ended - begun)


def growth(episodes: int) -> float:
    """Memory growth of a sweep per 1,000 episodes, after the first tenth [MB]."""
    peaks: list[int] = []

    def look(done: float) -> None:
        if done in (episodes // 10, episodes):
            peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

    with tempfile.TemporaryDirectory() as folder, EpisodeStore(Path(folder) / "store") as store:
        project = Path(folder)
        text = Catalog().find("scenario", "exp1").path.read_text("utf-8").replace('"60 s"', '"0.05 s"')
        (project / "scenarios").mkdir()
        (project / "scenarios" / "blink.toml").write_text(text, "utf-8")
        sweep(
            ["none"],
            ["blink"],
            range(episodes),
            catalog=Catalog(project),
            store=store,
            options=SweepOptions(workers=WORKERS),
            progress=look,
        )
    return (peaks[1] - peaks[0]) / 1024.0 / (0.9 * episodes / 1000.0)


def run() -> Iterator[Row]:
    """All rows."""
    play = 1.0 / episode_time("tree", [ScenarioScene("exp1")], SEEDS)
    yield Row("sweep: EXP1, one core", play, "episodes/s", budget=">= 3", holds=play >= 3.0)
    barn = 1.0 / episode_time("hybrid", scenes_of("barn_like", FIELDS), FIELD_SEEDS)
    yield Row("sweep: barn_like with lidar, one core", barn, "episodes/s", budget=">= 1", holds=barn >= 1.0)
    whole, counted = sweep_times()
    share = 100.0 * (whole - counted) / whole
    yield Row("sweep: store and engine", share, "%", budget="< 5 %", holds=share < 5.0)
    yield Row(f"sweep: memory, {MANY} episodes", growth(MANY), "MB/1000", budget="< 5", holds=None)
    if cores() > 1:
        one, two = rate(1), rate(2)
        yield Row("sweep: two workers", two / one, "x one worker", budget=">= 1.8", holds=two >= 1.8 * one)
