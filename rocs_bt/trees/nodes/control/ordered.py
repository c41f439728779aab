"""Sequences and fallbacks: one outcome of a child passes on to the next child, the other ends the node.

The passing outcome is SUCCESS for a sequence and FAILURE for a fallback. A tick function is generated for each of
them, because a closure variable is read faster than an attribute.
"""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Sequence as Many
from itertools import islice
from typing import Any, cast

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector as StockSelector
from py_trees.composites import Sequence as StockSequence

from ...status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ..base_classes import Control, halt


class Ordered(Control):
    """Base of nodes that tick their children in order and resume at the RUNNING child; SKIPPED also passes on."""

    memory = True

    def _decided(self, outcome: Outcome, child: Behaviour) -> Outcome:
        if outcome is IDLE:
            raise self.no_outcome(child, outcome)
        if self._skipped:
            return self.ended(outcome, child)
        self.current_child = child
        self.status = outcome
        return outcome


def ordered(passing: Status) -> Callable[[Any], Outcome]:
    """Create the tick function of a subclass of `Ordered`; `passing` is also the outcome after its last child."""

    def tick_once(self: Ordered) -> Outcome:
        index = 0
        if self.status is not RUNNING:
            self._skipped = 0
            self.status = RUNNING
        elif self.current_child is not None:
            running: Any = self.current_child
            outcome = running.tick_once() or running.status
            if outcome is RUNNING:
                return RUNNING
            index = self.children.index(running) + 1
            if outcome is SKIPPED:
                self._skipped += 1
            elif outcome is not passing:
                return self._decided(outcome, running)
        children: list[Any] = self.children
        for child in islice(children, index, None) if index else children:
            outcome = child.tick_once() or child.status
            if outcome is passing:
                continue
            if outcome is SKIPPED:
                self._skipped += 1
                continue
            if outcome is RUNNING:
                self.current_child = child
                return RUNNING
            return self._decided(outcome, child)
        if self._skipped:
            return self.ended(SKIPPED if self._skipped == len(children) else passing, children[-1])
        self.current_child = children[-1]
        self.status = passing
        return passing

    return tick_once


class Reactive(Control):
    """Base of nodes that tick their children from the first one in each tick.

    If a child decides the outcome or is RUNNING, another child that is RUNNING from an earlier tick is halted.
    """

    memory = False
    run_aware_children = cast("Many[Any]", ())  # keep state after they have ended; notified when a new run begins


def reactive(passing: Status) -> Callable[[Any], Outcome]:
    """Create the tick function of a subclass of `Reactive`; argument as in `ordered`."""

    def tick_once(self: Reactive) -> Outcome:
        children: list[Any] = self.children
        runs_on = None
        if self.status is RUNNING:
            runs_on = self.current_child
        else:
            self.status = RUNNING
            for node in self.run_aware_children:
                node.begin()
        skipped = 0
        for child in children:
            outcome = child.tick_once()
            if outcome is None:
                outcome = child.status
            if outcome is passing:
                continue
            if outcome is not RUNNING:
                if outcome is SKIPPED:
                    skipped += 1
                    halt(child)
                    continue
                if outcome is IDLE:
                    raise self.no_outcome(child, outcome)
                self.status = outcome
            if runs_on is not child:
                if runs_on is not None:
                    halt(runs_on)  # at most one child is RUNNING
                self.current_child = child
            return outcome
        if skipped == len(children):
            self.current_child = None
            return SKIPPED
        self.current_child = children[-1]
        self.status = passing
        return passing

    return tick_once


class Yielding(Ordered):
    """Base of nodes that return RUNNING after each child that ends within one tick, so that other nodes can run.

    The tree is then ticked again without waiting (`Runtime.tick_again`).
    """

    def decided(self, outcome: Outcome, child: object) -> Outcome:
        """End the node with the outcome of a child."""
        return self.ended(outcome, self.current_child)


def yielding(passing: Status) -> Callable[[Any], Outcome]:
    """Create the tick function of a subclass of `Yielding`; argument as in `ordered`."""

    def tick_once(self: Yielding) -> Outcome:
        children: list[Any] = self.children
        if self.status is not RUNNING:
            self._skipped = 0
            self.status = RUNNING
        index = self._index
        while index < len(children):
            child = children[index]
            at_once = child.status is not RUNNING
            outcome = child.tick_once() or child.status
            self.current_child = child
            if outcome is RUNNING:
                self._index = index
                return RUNNING
            index += 1
            if outcome is passing:
                if at_once and index < len(children):
                    self._index = index
                    self.runtime.tick_again = True
                    return RUNNING
            elif outcome is SKIPPED:
                self._skipped += 1
            elif outcome is IDLE:
                raise self.no_outcome(child, outcome)
            else:
                return self.decided(outcome, child)
        self.halt_children()  # a child may have returned SKIPPED after RUNNING in an earlier run
        return self.ended(SKIPPED if self._skipped == len(children) else passing, children[-1])

    return tick_once


class Sequence(Ordered, StockSequence):
    """Ticks its children in order and stops at the first failure: FAILURE if a child fails, SUCCESS if none does.

    A RUNNING child makes the sequence RUNNING and is resumed by the next tick. Skipped children are passed over; the
    sequence is SKIPPED if all are. Fallback is the same with SUCCESS and FAILURE exchanged.
    """

    tick_once = ordered(SUCCESS)


class AsyncSequence(Yielding, StockSequence):
    """Sequence that returns RUNNING after each child that succeeds within one tick, so that other nodes can run."""

    tick_once = yielding(SUCCESS)


class SequenceWithMemory(Yielding, StockSequence):
    """AsyncSequence that resumes at the failed child instead of the first one, also after a halt."""

    tick_once = yielding(SUCCESS)

    def decided(self, outcome: Outcome, child: object) -> Outcome:
        """End the sequence and store the index of the failed child; only this child and those after it are halted."""
        index = next(i for i, c in enumerate(self.children) if c is child)
        for other in self.children[index:]:
            halt(other)
        self._index = index
        self.status = outcome
        return outcome

    def halted(self) -> None:
        self.halt_children()
        self.current_child = None


class SequenceStar(SequenceWithMemory):
    """Name of SequenceWithMemory in BehaviorTree.CPP 3, which many files of version 4 still use."""

    tick_once = SequenceWithMemory.tick_once


class ReactiveSequence(Reactive, StockSequence):
    """Ticks its children from the first one in each tick: conditions first, then the action that they permit.

    FAILURE if a child fails, SUCCESS if none does, SKIPPED if all are skipped. If a child is RUNNING or ends the
    sequence, all other RUNNING children are halted. ReactiveFallback is the same with SUCCESS and FAILURE exchanged.
    """

    tick_once = reactive(SUCCESS)


class Fallback(Ordered, StockSelector):
    """Ticks its children in order and stops at the first success: SUCCESS if a child succeeds, FAILURE if none does.

    Like Sequence with SUCCESS and FAILURE exchanged.
    """

    tick_once = ordered(FAILURE)


class AsyncFallback(Yielding, StockSelector):
    """Fallback that returns RUNNING after each child that fails within one tick, so that other nodes can run."""

    tick_once = yielding(FAILURE)


class ReactiveFallback(Reactive, StockSelector):
    """Ticks its children from the first one in each tick; the first that does not fail decides, the others are halted.

    Like ReactiveSequence with SUCCESS and FAILURE exchanged.
    """

    tick_once = reactive(FAILURE)
