"""What all nodes of one running tree have in common."""

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
"""Hears the outcome of every tick of every node, children before parents, and IDLE when a node was halted."""

Caught = Callable[["Behaviour", BaseException], bool]
"""Takes the exception of a leaf, which then counts as RUNNING; False to have it raised."""


class Runtime:
    """What all nodes of a tree can ask for.

    Args:
        clock: Source of time; nodes that wait read no other one.
        owner: Whoever the tree works for, such as a robot's mission; nodes that need it look for their own kind.

    Attributes:
        owner: The same.
        now: Gives the time [s]; raises a TreeError in a tree without a clock.
        watch: Who hears of each tick; None for nobody. Nodes take it over when they are bound.
        caught: Takes the exceptions of leaves.
        faults: What nodes found wrong as they were bound: the node, its attribute, the fault.
        woken: Set by a node that stopped half way only to let others have their turn: tick again, do not wait.
    """

    def __init__(self, clock: Clock | None = None, owner: object = None) -> None:
        self.now: Callable[[], float] = _no_clock if clock is None else clock.now
        self.owner = owner
        self.watch: Watch | None = None
        self.caught: Caught = lambda leaf, error: False
        self.faults: list[tuple[Behaviour, str, Fault]] = []
        self.woken = False


def _no_clock() -> float:
    raise TreeError(Fault("a node asks the time, and its tree was given no clock."))
