"""Executor for tests of the wall limit that do not depend on the machine's speed."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import replace
from typing import Any

from rocs_bt.compare.episode import Episode

from ..waiting import GUARD


class Patient(Executor):
    """Lifts the wall limit of every trial except those that hang: the others may take as long as the machine needs.

    Args:
        executor: Executor that plays the trials.
        hangs: Whether a trial hangs.
    """

    def __init__(self, executor: Executor, hangs: Callable[[Episode], bool]) -> None:
        self._executor = executor
        self._hangs = hangs

    def submit(self, fn: Callable[[Episode], Any], episode: Episode) -> Future[Any]:
        limit = episode.wall_limit if self._hangs(episode) else 10 * GUARD
        return self._executor.submit(fn, replace(episode, wall_limit=limit))
