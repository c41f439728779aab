"""Parallels: all children in each tick."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Sequence as Many
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy
from py_trees.composites import Parallel as StockParallel

from ....errors import Fault
from ...error import TreeError
from ...status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ..family import Control
from ..port import Input


class _Together(Control, StockParallel):
    """What both parallels do: a child that has ended is not ticked again until the parallel has."""

    def __init__(self, name: str, children: Many[Behaviour] = (), /, **attributes: Any) -> None:
        super().__init__(name, children, **attributes)
        self.policy = ParallelPolicy.SuccessOnAll(synchronise=True)  # for py_trees' displays
        self._completed: set[Behaviour] = set()
        self._failures = 0

    def halted(self) -> None:
        super().halted()
        self._completed.clear()
        self._failures = 0

    def doubts(self) -> Iterator[tuple[str, Fault]]:
        for port in self.ports:
            if self.key(port) is None and (wanted := self.read(port)) > len(self.children):
                yield port, Fault(f"'{self.name}' waits for {wanted} of its children, and has {len(self.children)}.")

    def setup(self, **kwargs: Any) -> None:
        """Nothing: the thresholds are read in each tick."""

    def _finish(self, outcome: Outcome) -> Outcome:
        self._completed.clear()
        self._failures = 0
        self.halt_children()
        self.current_child = self.children[-1]
        self.status = outcome
        return outcome

    def _threshold(self, count: int) -> int:
        """A negative count is one from the end: -1 is all children."""
        return count if count >= 0 else max(len(self.children) + count + 1, 0)


class Parallel(_Together):
    """Ticks its children in order and decides after each of them, so the last ones may not be ticked in a tick.

    SUCCESS when `success_count` children have succeeded, FAILURE when `failure_count` have failed or success became
    impossible. Negative counts are from the end. A child that is skipped counts as a success only where `success_count`
    is negative.
    """

    success_count = Input(int, -1, "how many children have to succeed; -1 is all of them")
    failure_count = Input(int, 1, "how many children have to fail")

    def tick_once(self) -> Outcome:
        children: list[Any] = self.children
        given, count = self.read("success_count"), len(children)
        failing = self.read("failure_count")
        needed = given if given >= 0 else self._threshold(given)
        failing = failing if failing >= 0 else self._threshold(failing)
        if needed > count or failing > count:
            raise TreeError(Fault(f"'{self.name}' waits for {max(needed, failing)} of its children, and has {count}."))
        self.status = RUNNING
        completed, failures, skipped = self._completed, self._failures, 0
        succeeded, ended = len(completed) - failures, []
        for child in children:
            if not completed or child not in completed:
                outcome = child.tick_once() or child.status
                if outcome is SUCCESS:
                    ended.append(child)
                    succeeded += 1
                elif outcome is FAILURE:
                    ended.append(child)
                    failures += 1
                elif outcome is SKIPPED:
                    skipped += 1
                elif outcome is IDLE:
                    raise self.strange(child, outcome)
            if succeeded >= needed or (skipped and given < 0 and succeeded + skipped >= needed):
                return self._finish(SUCCESS)
            if failures == failing or count - failures < needed:
                return self._finish(FAILURE)
        completed.update(ended)
        self._failures = failures
        if skipped == count:
            return SKIPPED
        self.current_child = children[-1]
        return RUNNING


class ParallelAll(_Together):
    """Ticks all children until all have ended; FAILURE if at least `max_failures` of them failed, SUCCESS otherwise."""

    max_failures = Input(int, 1, "how many failures make it fail; negative counts are from the end")

    def tick_once(self) -> Outcome:
        children, failing = self.children, self._threshold(self.max_failures)
        if failing > len(children):
            raise TreeError(Fault(f"'{self.name}' waits for {failing} failures, and has {len(children)} children."))
        self.status = RUNNING
        skipped = 0
        for child in children:
            if child not in self._completed:
                skipped += self._tick(child) is SKIPPED
        if skipped == len(children):
            return SKIPPED
        if skipped + len(self._completed) >= len(children):
            return self._finish(FAILURE if self._failures >= failing else SUCCESS)
        self.current_child = next(c for c in children if c not in self._completed)
        return RUNNING

    def _tick(self, child: Any) -> Outcome:
        outcome = child.tick_once() or child.status
        if outcome is SUCCESS:
            self._completed.add(child)
        elif outcome is FAILURE:
            self._completed.add(child)
            self._failures += 1
        elif outcome is IDLE:
            raise self.strange(child, outcome)
        return outcome
