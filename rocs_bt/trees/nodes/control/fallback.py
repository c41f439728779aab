"""Fallbacks: one child after the other, until one succeeds."""

from __future__ import annotations

from py_trees.composites import Selector as StockSelector

from ...status import FAILURE
from .ordered import Ordered, Reactive, Yielding, ordered, reactive, yielding


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
