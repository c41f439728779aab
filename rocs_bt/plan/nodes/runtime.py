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

    from ..mission import Mission

Watch = Callable[["Behaviour", Outcome], None]
"""Hears the outcome of every tick of every node, children before parents, and IDLE when a node was halted."""

Caught = Callable[["Behaviour", BaseException], bool]
"""Takes the exception of a leaf, which then counts as RUNNING; False to have it raised."""


class Runtime:
    """The clock, the mission and the ears of a tree.

    Args:
        clock: Time; nodes that wait read no other one.
        mission: Whose tree it is; None for a tree without a robot.

    Attributes:
        now: Gives the time [s]; raises a TreeError in a tree without a clock.
        watch: Who hears of each tick; None for nobody. Nodes take it over when they are bound.
        caught: Takes the exceptions of leaves.
        faults: What nodes found wrong as they were bound: the node, its attribute, the fault.
        woken: Set by a node that stopped half way only to let others have their turn: tick again, do not wait.
    """

    def __init__(self, clock: Clock | None = None, mission: Mission | None = None) -> None:
        self.now: Callable[[], float] = _no_clock if clock is None else clock.now
        self._mission = mission
        self.watch: Watch | None = None
        self.caught: Caught = lambda leaf, error: False
        self.faults: list[tuple[Behaviour, str, Fault]] = []
        self.woken = False

    @property
    def mission(self) -> Mission:
        """Whose tree it is.

        Raises:
            TreeError: It is nobody's.
        """
        if self._mission is None:
            raise TreeError(Fault("a node asks for its mission, and its tree was given none."))
        return self._mission

    @property
    def has_mission(self) -> bool:
        """Whether it is somebody's tree."""
        return self._mission is not None


def _no_clock() -> float:
    raise TreeError(Fault("a node asks the time, and its tree was given no clock."))
