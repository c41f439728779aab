"""Sequences and fallbacks: one outcome passes on to the next child, the other decides.

The ticks are made for the outcome that passes: a constant of the function is looked up faster than an attribute.
"""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Sequence as Many
from itertools import islice
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector as StockSelector
from py_trees.composites import Sequence as StockSequence

from ...status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ..family import Control, halt


class Ordered(Control):
    """Ticks children in order and goes on where it was RUNNING; SKIPPED passes on too."""

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
    """The tick of an `Ordered`.

    Args:
        passing: The outcome after which the next child is ticked; also the outcome when none is left.
    """

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
    """Ticks all children in each tick; when one is RUNNING, the others are halted, those before it too.

    Attributes:
        keepers: Children that keep something while they are ticked again after they ended, told when it begins anew.
    """

    memory = False
    keepers: Many[Any] = ()


def reactive(passing: Status) -> Callable[[Any], Outcome]:
    """The tick of a `Reactive`; see `ordered`."""

    def tick_once(self: Reactive) -> Outcome:
        children: list[Any] = self.children
        runs_on = None
        if self.status is RUNNING:
            runs_on = self.current_child
        else:
            self.status = RUNNING
            for keeper in self.keepers:
                keeper.begin()
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
                    halt(runs_on)  # no other one can be RUNNING
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
    """Gives others their turn after each child that was done at once: RUNNING in between, and the tree is woken."""

    def decided(self, outcome: Outcome, child: object) -> Outcome:
        """A child has decided."""
        return self.ended(outcome, self.current_child)


def yielding(passing: Status) -> Callable[[Any], Outcome]:
    """The tick of a `Yielding`; see `ordered`."""

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
                    self.runtime.woken = True
                    return RUNNING
            elif outcome is SKIPPED:
                self._skipped += 1
            elif outcome is IDLE:
                raise self.no_outcome(child, outcome)
            else:
                return self.decided(outcome, child)
        self.halt_children()  # some may have skipped half way in a run before this one
        return self.ended(SKIPPED if self._skipped == len(children) else passing, children[-1])

    return tick_once


class Sequence(Ordered, StockSequence):
    """Ticks its children in order; the first that fails ends it.

    | child | the sequence |
    |---|---|
    | SUCCESS, SKIPPED | goes on with the next one |
    | RUNNING | RUNNING; the next tick goes on with this child |
    | FAILURE | FAILURE |
    | none left | SUCCESS; SKIPPED if all were |
    """

    tick_once = ordered(SUCCESS)


class AsyncSequence(Yielding, StockSequence):
    """A Sequence that is RUNNING for a moment after each child that succeeded at once: others have their turn."""

    tick_once = yielding(SUCCESS)


class SequenceWithMemory(Yielding, StockSequence):
    """An AsyncSequence that tries a child that failed again, instead of beginning with the first, also after a halt."""

    tick_once = yielding(SUCCESS)

    def decided(self, outcome: Outcome, child: object) -> Outcome:
        """The sequence fails, and keeps its place; what comes after it is halted, what came before is not."""
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
    """The name of SequenceWithMemory in BehaviorTree.CPP version 3, which many files of version 4 still use."""

    tick_once = SequenceWithMemory.tick_once


class ReactiveSequence(Reactive, StockSequence):
    """Asks all children anew in each tick: conditions first, then what is done while they hold.

    | child | the sequence |
    |---|---|
    | SUCCESS | goes on with the next one |
    | SKIPPED | the same |
    | RUNNING | RUNNING; all other children that are RUNNING are halted |
    | FAILURE | FAILURE; all children that are RUNNING are halted |
    | none left | SUCCESS; SKIPPED if all were |
    """

    tick_once = reactive(SUCCESS)


class Fallback(Ordered, StockSelector):
    """Ticks its children in order; the first that succeeds ends it.

    | child | the fallback |
    |---|---|
    | FAILURE, SKIPPED | goes on with the next one |
    | RUNNING | RUNNING; the next tick goes on with this child |
    | SUCCESS | SUCCESS |
    | none left | FAILURE; SKIPPED if all were |
    """

    tick_once = ordered(FAILURE)


class AsyncFallback(Yielding, StockSelector):
    """A Fallback that is RUNNING for a moment after each child that failed at once: others have their turn."""

    tick_once = yielding(FAILURE)


class ReactiveFallback(Reactive, StockSelector):
    """Asks all children anew in each tick; the first that does not fail is what it does, and the others are halted.

    | child | the fallback |
    |---|---|
    | FAILURE, SKIPPED | goes on with the next one |
    | RUNNING | RUNNING; all other children that are RUNNING are halted |
    | SUCCESS | SUCCESS; all children that are RUNNING are halted |
    | none left | FAILURE; SKIPPED if all were |
    """

    tick_once = reactive(FAILURE)
