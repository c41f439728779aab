"""Parallel nodes, which tick all children in each tick."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from collections.abc import Sequence as Many
from typing import Annotated, Any

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy
from py_trees.composites import Parallel as StockParallel

from ....base.errors import Fault
from ...board import Board
from ...error import TreeError
from ...status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ..base_classes import Control
from ..runtime import Runtime


class _ParallelBase(Control, StockParallel):
    """Base of both parallel nodes: a child that has ended is not ticked again until the parallel node has ended."""

    def __init__(self, name: str, children: Many[Behaviour] = (), /, **attributes: Any) -> None:
        super().__init__(name, children, **attributes)
        self.policy = ParallelPolicy.SuccessOnAll(synchronise=True)  # for py_trees' displays
        self._completed: set[Behaviour] = set()
        self._failures = 0
        self._fixed = all(self.key(port) is None for port in self.ports)
        self._limits: tuple[int, ...] = ()

    def bind(self, board: Board, runtime: Runtime) -> Iterable[tuple[Behaviour, Board]]:
        self._limits = ()  # the number of children may have changed
        return super().bind(board, runtime)

    def halted(self) -> None:
        super().halted()
        self._completed.clear()
        self._failures = 0

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        for port in self.ports:
            if self.key(port) is None and (wanted := self.read(port)) > len(self.children):
                yield port, Fault(f"'{self.name}' waits for {wanted} children but has {len(self.children)}.")

    def setup(self, **kwargs: Any) -> None:
        """Do nothing: py_trees would check its policy here, but the thresholds are read in each tick."""

    def _finish(self, outcome: Outcome) -> Outcome:
        self._completed.clear()
        self._failures = 0
        self.halt_children()
        self.current_child = self.children[-1]
        self.status = outcome
        return outcome

    def _read(self) -> tuple[int, ...]:
        """Thresholds as numbers of children, in the order of the ports; cached unless a port is a blackboard key."""
        count = len(self.children)
        given = [self.read(port) for port in self.ports]
        limits = tuple(n if n >= 0 else max(count + n + 1, 0) for n in given)  # -1 is all children
        if max(limits) > count:
            raise TreeError(Fault(f"'{self.name}' waits for {max(limits)} children but has {count}."))
        if self._fixed:
            self._limits = limits
        return limits


class Parallel(_ParallelBase):
    """Ticks its children in order and decides after each of them, so that a tick may not reach the last ones.

    SUCCESS when `success_count` children have succeeded, FAILURE when `failure_count` have failed or success has become
    impossible. Negative counts are from the end. A skipped child counts as a success only if `success_count` is
    negative.
    """

    success_count: Annotated[int, "number of successes that make it succeed; -1 for all children"] = -1
    failure_count: Annotated[int, "number of failures that make it fail; negative counts are from the end"] = 1

    def tick_once(self) -> Outcome:
        needed, failing = self._limits or self._read()
        if self.status is not RUNNING:
            self.status = RUNNING
            self.current_child = self.children[-1]
        settled = self._limits and needed and failing  # a RUNNING child cannot end the node
        children: list[Any] = self.children
        completed, skipped, count = self._completed, 0, len(children)
        for child in children:
            if not completed or child not in completed:
                outcome = child.tick_once()
                if outcome is None:
                    outcome = child.status
                if outcome is RUNNING and settled:
                    continue
                if outcome is SUCCESS:
                    completed.add(child)
                elif outcome is FAILURE:
                    completed.add(child)
                    self._failures += 1
                elif outcome is SKIPPED:
                    skipped += 1
                elif outcome is IDLE:
                    raise self.no_outcome(child, outcome)
            failures = self._failures
            succeeded = len(completed) - failures
            if succeeded >= needed or (skipped and succeeded + skipped >= needed and self.read("success_count") < 0):
                return self._finish(SUCCESS)
            if failures == failing or count - failures < needed:
                return self._finish(FAILURE)
        return SKIPPED if skipped == count else RUNNING


class ParallelAll(_ParallelBase):
    """Ticks all children until all have ended; FAILURE if at least `max_failures` of them failed, else SUCCESS."""

    max_failures: Annotated[int, "number of failures that make it fail; negative counts are from the end"] = 1

    def tick_once(self) -> Outcome:
        children: list[Any] = self.children
        (failing,) = self._limits or self._read()
        self.status = RUNNING
        completed, skipped, under_way = self._completed, 0, None
        for child in children:
            if not completed or child not in completed:
                outcome = child.tick_once() or child.status
                if outcome is SKIPPED:
                    skipped += 1
                elif outcome is SUCCESS or outcome is FAILURE:
                    completed.add(child)
                    self._failures += outcome is FAILURE
                elif outcome is IDLE:
                    raise self.no_outcome(child, outcome)
                else:
                    under_way = under_way or child
        if skipped == len(children):
            return SKIPPED
        if skipped + len(completed) >= len(children):
            return self._finish(FAILURE if self._failures >= failing else SUCCESS)
        self.current_child = under_way
        return RUNNING
