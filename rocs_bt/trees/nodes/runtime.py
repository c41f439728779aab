"""State shared by all nodes of a running tree."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ...clock import Clock
from ...errors import Fault
from ..error import TreeError
from ..status import Outcome

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

Watch = Callable[["Behaviour", Outcome], None]
"""Callback with the outcome of every tick of every node, children before parents, and IDLE for a halted node."""

Caught = Callable[["Behaviour", BaseException], bool]
"""Handler of an exception in a leaf: True if handled, the leaf then counts as RUNNING; False to raise it."""


class Runtime:
    """State shared by all nodes of a tree.

    Args:
        clock: Time source for nodes that wait.
        owner: Object that the tree works for, such as a robot's mission; nodes check its type before they use it.

    Attributes:
        owner: The owner.
        now: Function that returns the time [s]; raises a TreeError in a tree without a clock.
        watch: Observer of each tick, or None. Nodes adopt it when they are bound.
        caught: Handler of exceptions in leaves.
        faults: Faults found while nodes were bound: the node, its attribute, the fault.
        tick_again: Set by a node that returned RUNNING only to let other nodes run: tick again without waiting.
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
