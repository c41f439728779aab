"""What a worker does with a trial, in whichever process an executor runs it."""

from __future__ import annotations

import faulthandler
import multiprocessing
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from multiprocessing.util import Finalize
from pathlib import Path

from ..errors import InputError
from .bench import Bench
from .metric import LOST, METRICS
from .record import EpisodeRecord
from .store import Cost
from .trial import Trial

_ONE = threading.Lock()  # a process plays one episode at a time, however many threads an executor has in it


def work(trial: Trial) -> tuple[EpisodeRecord, Cost]:
    """Play a trial. An episode that breaks down is a record as well, with the outcome `error`.

    In a process that an executor started a trial that takes longer than its wall limit ends that process, even where
    it hangs in C code that holds the interpreter: whoever started it does the rest.

    Raises:
        InputError: Something in the content is wrong, so that no other episode would do better.
    """
    with _ONE, _limited(trial.wall_limit):
        wall, cpu = time.perf_counter(), time.process_time()
        bench = _bench(trial.project, trial.code)
        limit = bench.setting(trial.place).scenario.duration
        try:
            record = bench.play(trial)
        except InputError:
            raise
        except Exception as error:  # noqa: BLE001 - the process's boundary: one broken episode must not end a sweep
            record = broken(trial, f"{type(error).__name__}: {error}", limit, reproducible=True)
        return record, Cost(time.perf_counter() - wall, time.process_time() - cpu)


def broken(trial: Trial, reason: str, time_limit: float, *, reproducible: bool) -> EpisodeRecord:
    """The record of an episode that did not come to an end: a failure, of which nothing else is known.

    Args:
        trial: What was to be played.
        reason: Why it broke down.
        time_limit: T_max [s]; 0 where that is not known either.
        reproducible: Whether it would break down again.
    """
    time = time_limit if time_limit > 0.0 else None
    return EpisodeRecord(
        key=trial.key,
        planner=trial.planner.name,
        family=trial.place.group,
        scene=trial.place.name,
        seed=trial.seed,
        outcome="error",
        reason=reason,
        metrics={**dict.fromkeys(METRICS), **dict.fromkeys(LOST, 0.0), "time": time},
        time_limit=time_limit,
        reproducible=reproducible,
    )


@lru_cache(maxsize=1)
def _bench(project: Path | None, code: bool) -> Bench:
    """This process's bench; a worker lets go of its scenes when it ends, where nothing else would."""
    bench = Bench(project, code=code)
    Finalize(bench, bench.close, exitpriority=0)
    return bench


@contextmanager
def _limited(seconds: float) -> Iterator[None]:
    """End this process, where it is nobody's main one, unless the block is done in time [s]."""
    if multiprocessing.parent_process() is None:
        yield
        return
    # faulthandler's clock is a thread in C that needs no interpreter lock; it tells on stderr where the process hung.
    faulthandler.dump_traceback_later(seconds, exit=True)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
