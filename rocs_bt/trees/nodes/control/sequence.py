"""Sequences: one child after the other, for as long as they succeed."""

from __future__ import annotations

from py_trees.composites import Sequence as StockSequence

from ...status import SUCCESS, Outcome
from ..family import halt
from .ordered import Ordered, Reactive, Yielding, ordered, reactive, yielding


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
