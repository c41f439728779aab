"""What lasts while a parent ticks a node again and again, also after the node has ended."""

from __future__ import annotations

from collections.abc import Iterable

from py_trees.behaviour import Behaviour

from ...trees.board import Board
from ...trees.nodes import Decorator, Instant, Runtime
from ...trees.nodes.control.branch import WhileDoElse
from ...trees.nodes.control.navigation import NonblockingSequence, PipelineSequence
from ...trees.nodes.control.ordered import Reactive
from ...trees.nodes.node import Node
from ...trees.status import RUNNING

_AGAIN = (Reactive, PipelineSequence, NonblockingSequence, WhileDoElse)
"""Parents that tick children that have ended again, and reset them when they end themselves."""


class Keeping(Node):
    """Tells the first tick of a run from later ones, as a node of BehaviorTree.CPP does by being IDLE.

    Under a parent of another kind every tick of a node that is not RUNNING begins a run.
    """

    _fresh = True
    _kept = False

    def bind(self, board: Board, runtime: Runtime) -> Iterable[tuple[Behaviour, Board]]:
        parent = self.parent
        if isinstance(parent, _AGAIN):
            self._kept = True
            parent.keepers = [*(k for k in parent.keepers if k is not self), self]
        return super().bind(board, runtime)

    def begin(self) -> None:
        """Called by the parent when it begins."""
        self._fresh = True

    def begins(self) -> bool:
        """Whether this tick begins a run; to be asked once in each tick."""
        first = self.status is not RUNNING and (self._fresh or not self._kept)
        self._fresh = False
        return first

    def halted(self) -> None:
        self._fresh = True
        super().halted()


class KeepingDecorator(Keeping, Decorator):
    """The base of decorators that keep something between ticks."""


class KeepingCondition(Keeping, Instant):
    """The base of conditions that keep something between ticks."""

    kind = "Condition"
