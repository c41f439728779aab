"""Base classes of nodes that keep state during a run of their parent, even after they have ended themselves."""

from __future__ import annotations

from collections.abc import Iterable

from py_trees.behaviour import Behaviour

from ..trees.board import Board
from ..trees.nodes import Decorator, Instant, Runtime
from ..trees.nodes.control.branch import WhileDoElse
from ..trees.nodes.control.navigation import NonblockingSequence, PipelineSequence
from ..trees.nodes.control.ordered import Reactive
from ..trees.nodes.node import Node
from ..trees.status import RUNNING

_RETICKING = (Reactive, PipelineSequence, NonblockingSequence, WhileDoElse)
"""Parents that tick children again that have ended; such children begin a new run when the parent does."""


class RunAware(Node):
    """Base of nodes that distinguish the first tick of a run from later ones.

    In BehaviorTree.CPP a node is IDLE in the first tick, because its parent resets it. Here, parents that tick ended
    children again call `begin`. Under any other parent, a tick of a node that is not RUNNING begins a run.
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
        """Make the next tick begin a run; the parent calls this in the first tick of its own run."""
        self._new_run = True

    def begins(self) -> bool:
        """Whether this tick begins a run; call this once in each tick."""
        first = self.status is not RUNNING and (self._new_run or not self._parent_notifies)
        self._new_run = False
        return first

    def halted(self) -> None:
        self._new_run = True
        super().halted()


class RunAwareDecorator(RunAware, Decorator):
    """Base class of decorators that keep state during a run of their parent."""


class RunAwareCondition(RunAware, Instant):
    """Base class of conditions that keep state during a run of their parent."""

    kind = "Condition"
