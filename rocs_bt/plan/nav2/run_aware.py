"""Nodes that keep state between ticks of one run of their parent, also after they have ended."""

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

_RETICKING = (Reactive, PipelineSequence, NonblockingSequence, WhileDoElse)
"""Parents that tick ended children again, and reset them when they end themselves."""


class RunAware(Node):
    """Distinguishes the first tick of a run from later ones, as a node of BehaviorTree.CPP does by being IDLE.

    Under any other parent each tick of a node that is not RUNNING begins a run.
    """

    _new_run = True
    _parent_notifies = False

    def bind(self, board: Board, runtime: Runtime) -> Iterable[tuple[Behaviour, Board]]:
        parent = self.parent
        if isinstance(parent, _RETICKING):
            self._parent_notifies = True
            parent.run_aware_children = [*(k for k in parent.run_aware_children if k is not self), self]
        return super().bind(board, runtime)

    def begin(self) -> None:
        """Begin a new run; the parent calls this on its own first tick after it ended or was halted."""
        self._new_run = True

    def begins(self) -> bool:
        """Whether this tick begins a run; call it once per tick."""
        first = self.status is not RUNNING and (self._new_run or not self._parent_notifies)
        self._new_run = False
        return first

    def halted(self) -> None:
        self._new_run = True
        super().halted()


class RunAwareDecorator(RunAware, Decorator):
    """Base class of decorators that keep state between ticks."""


class RunAwareCondition(RunAware, Instant):
    """Base class of conditions that keep state between ticks."""

    kind = "Condition"
