"""Executor for tests of the wall limit that do not depend on the machine's speed."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import replace
from typing import Any

from rocs_bt.compare.trial import Trial

from ..waiting import GUARD


class Patient(Executor):
    """Lifts the wall limit of every trial except those that hang: the others may take as long as the machine needs.

    Args:
        executor: Executor that plays the trials.
        hangs: Whether a trial hangs.
    """

    def __init__(self, executor: Executor, hangs: Callable[[Trial], bool]) -> None:
        self._executor = executor
        self._hangs = hangs

    def submit(self, fn: Callable[[Trial], Any], trial: Trial) -> Future[Any]:
        limit = trial.wall_limit if self._hangs(trial) else 10 * GUARD
        return self._executor.submit(fn, replace(trial, wall_limit=limit))
