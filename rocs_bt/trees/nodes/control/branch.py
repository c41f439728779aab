"""Controls that ask a condition which of their other children is to be ticked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from py_trees.behaviour import Behaviour

from ....errors import Fault
from ...error import TreeError
from ...status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ..family import Control, halt


class _Branch(Control):
    """What both have in common: children are the condition, then, and otherwise, which may be left out."""

    least, most = 2, 3

    def _fails(self, outcome: Outcome) -> bool:
        """False, for a condition that failed.

        Raises:
            TreeError: It was skipped, or has no outcome.
        """
        if outcome is SKIPPED:
            hint = "Put the condition for skipping on the whole node."
            raise TreeError(Fault(f"the condition of '{self.name}' ({self.tag}) was skipped.", hint=hint))
        if outcome is IDLE:
            raise self.strange(self.children[0], outcome)
        return False

    def _finish(self, outcome: Outcome) -> Outcome:
        """End with the outcome of the present child."""
        if outcome is IDLE and self.current_child is not None:
            raise self.strange(self.current_child, outcome)
        self.halt_children()
        self._index = 0
        if outcome is not SKIPPED:
            self.status = outcome
        return outcome


class IfThenElse(_Branch):
    """Asks its first child once, then ticks the second if it succeeded, the third if it failed, until that has ended.

    Without a third child the failure of the condition is FAILURE. The condition is not asked again meanwhile.
    """

    def tick_once(self) -> Outcome:
        children = self.children
        self.status = RUNNING
        if self._index == 0:
            condition: Any = children[0]
            outcome = condition.tick_once() or condition.status
            self.current_child = condition
            if outcome is RUNNING:
                return outcome
            self._index = 1 if outcome is SUCCESS or self._fails(outcome) else 2
            if self._index == len(children):
                return self._finish(FAILURE)
        branch: Any = children[self._index]
        outcome = branch.tick_once() or branch.status
        self.current_child = branch
        return outcome if outcome is RUNNING else self._finish(outcome)


class WhileDoElse(_Branch):
    """Asks its first child in each tick and ticks the second while it succeeds, the third while it fails.

    When the condition turns over, the branch that was RUNNING is halted. Without a third child the failure of the
    condition is FAILURE. A condition that has a state, unlike one that is done at once, is asked only once per run of
    the node, as in BehaviorTree.CPP, because nothing resets it while a branch is RUNNING.

    Attributes:
        keepers: Children that keep a state after they have ended, until the node begins another run.
    """

    keepers: Sequence[Any] = ()

    def __init__(
        self, name: str, children: tuple[Behaviour, ...] | list[Behaviour] = (), /, **attributes: object
    ) -> None:
        super().__init__(name, children, **attributes)
        self._answer: Outcome | None = None

    def halted(self) -> None:
        super().halted()
        self._answer = None

    def tick_once(self) -> Outcome:
        children = self.children
        for keeper in self.keepers if self.status is not RUNNING else ():
            keeper.begin()
        self.status = RUNNING
        condition: Any = children[0]
        outcome = self._answer or condition.tick_once() or condition.status
        if outcome is RUNNING:
            self.current_child = condition
            return outcome
        holds = outcome is SUCCESS or self._fails(outcome)
        if getattr(condition, "latches", False):
            self._answer = outcome
        if len(children) == 3:
            other = children[2 if holds else 1]
            if other.status is RUNNING:
                halt(other)
        elif not holds:
            return self._finish(FAILURE)
        branch: Any = children[1 if holds else 2]
        outcome = branch.tick_once() or branch.status
        self.current_child = branch
        return outcome if outcome is RUNNING else self._finish(outcome)

    def _finish(self, outcome: Outcome) -> Outcome:
        self._answer = None
        return super()._finish(outcome)
