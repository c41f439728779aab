"""State shared by all nodes of a running tree."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ...base.clock import Clock
from ...base.errors import Fault
from ..error import TreeError
from ..status import Outcome

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

Watch = Callable[["Behaviour", Outcome], None]
"""Observer that is called with each node and its outcome after each of its ticks, or with IDLE when it is halted."""

Caught = Callable[["Behaviour", BaseException], bool]
"""Handler of an exception in a leaf. It returns True if the leaf counts as RUNNING, False to raise the exception."""


class Runtime:
    """State shared by all nodes of a tree.

    Args:
        clock: Time source for nodes that wait.
        owner: Object that the tree works for, such as a robot's mission; nodes check its type before they use it.

    Attributes:
        owner: Object that the tree works for.
        now: Function that returns the time [s]; raises a TreeError in a tree without a clock.
        watch: Observer of the ticks of all nodes, or None. Nodes wrap their ticks with it when they are bound.
        caught: Handler of exceptions in leaves.
        faults: Faults found while nodes were bound, as tuples of node, attribute and fault.
        tick_again: Whether a node returned RUNNING only to let other nodes run, so that the tree can be ticked again
            without waiting.
    """

    def __init__(self, clock: Clock | None = None, owner: object = None) -> None:
        self.now: Callable[[], float] = _no_clock if clock is None else clock.now
        self.owner = owner
        self.watch: Watch | None = None
        self.caught: Caught = lambda leaf, error: False
        self.faults: list[tuple[Behaviour, str, Fault]] = []
        self.tick_again = False


def _no_clock() -> float:
    raise TreeError(Fault("a node needs the time, but its tree has no clock; pass `clock` to Tree."))
