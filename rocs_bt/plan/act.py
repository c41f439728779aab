"""Act: leaf of a behaviour tree that executes an action of the robot."""

from __future__ import annotations

import math
from collections.abc import Callable

from py_trees.common import Status

from ..base.errors import InputError
from ..event import Replanned
from ..interfaces.action import Action, Failure, Reason, parameters_of
from ..interfaces.pipeline import Priority, Ticket, TicketState
from ..trees.nodes import Leaf
from ..trees.xml.write import value_text
from .context import MissionContext

PROGRESS = 0.05
"""Minimum reduction of the remaining distance to the goal that counts as progress [m]."""

MAX_PREEMPTIONS = 30
"""Maximum number of pre-emptions by reflexes without progress before the leaf fails."""


class Act(Leaf):
    """Leaf that submits one action to the pipeline and returns the action's state; it never blocks.

    The leaf is RUNNING while the action is queued or runs, and returns SUCCESS or FAILURE when the action has ended,
    with the reason in `feedback_message`. When a reflex cancels the action, the leaf stays RUNNING and submits a new
    action after the reflex. The new action uses current knowledge, and its method `resume` can take over state of the
    cancelled one. When the leaf is halted, it cancels its action.

    Args:
        name: Name in displays.
        mission: Context of the mission that contains the leaf.
        make: Function that creates the action; it is called for each submission.
        max_preemptions: Maximum number of pre-emptions by reflexes without progress; then the leaf fails.

    Attributes:
        make: Function that creates the action without submitting it.
        ticket: Ticket of the last submission; None before the first.
        replans: Number of submissions after an interruption by a reflex or an exception.
        failure: Reason why the leaf failed; None if it has not failed.
    """

    def __init__(
        self,
        name: str,
        mission: MissionContext,
        make: Callable[[], Action],
        max_preemptions: int = MAX_PREEMPTIONS,
    ) -> None:
        super().__init__(name)
        self._mission = mission
        self._set_up(make, max_preemptions)

    def written(self) -> tuple[str, dict[str, str]] | None:
        try:
            action = self.make()
        except InputError:  # reported by the check; the tree can still be drawn
            return type(self).__name__, {}
        declared, given = parameters_of(type(action)), action.parameters
        changed = {n: v for n, v in given.items() if n in declared and v is not None and v != declared[n].default}
        return type(action).__name__, {n: value_text(v, declared[n].dimension) for n, v in changed.items()}

    @property
    def mission(self) -> MissionContext:
        """Context of the mission that contains the leaf."""
        return self._mission

    def _set_up(self, make: Callable[[], Action], max_preemptions: int) -> None:
        self.make = make
        self.ticket: Ticket | None = None
        self.replans = 0
        self.failure: Failure | None = None
        self._max_preemptions = max_preemptions
        self._preemptions = 0
        self._nearest = math.inf
        self._counted = True

    def initialise(self) -> None:
        self.failure = None
        self._preemptions, self._nearest = 0, math.inf
        self._submit()

    def update(self) -> Status:
        ticket = self.ticket
        if ticket is None:
            return Status.FAILURE
        if ticket.state is TicketState.SUCCEEDED:
            self.feedback_message = f"{ticket.action.name} succeeded"
            return Status.SUCCESS
        if ticket.state is TicketState.FAILED:
            failure = ticket.failure or Failure(Reason.OTHER)
            return self._resubmit(ticket, "its exception") if failure.reason is Reason.RAISED else self._fail(failure)
        if ticket.state is TicketState.CANCELLED:
            if ticket.preempted:
                return self._resubmit(ticket, ticket.cancelled_by)
            return self._fail(Failure(Reason.OTHER, f"{ticket.action.name} was cancelled by {ticket.cancelled_by}"))
        self.feedback_message = f"{ticket.action.name} {ticket.state.name.lower()}"
        return Status.RUNNING

    def wait_text(self) -> str:
        if self.ticket is None or self.ticket.state.done:
            return self.feedback_message
        return self.ticket.action.awaits()

    def terminate(self, new_status: Status) -> None:
        # py_trees also calls this for leaves that have already ended; these have nothing to cancel.
        if new_status is Status.INVALID and self.status is Status.RUNNING and self.ticket is not None:
            self.mission.pipeline.cancel(self.ticket, by=self.mission.path(self))
            self._drop_goal()

    def _submit(self, interrupted: Action | None = None) -> None:
        self._counted = False
        action = self.make()
        if interrupted is not None:
            action.resume(interrupted)
        self.ticket = self.mission.pipeline.submit(action, Priority.NORMAL, by=self.mission.path(self))

    def _resubmit(self, ticket: Ticket, cause: str) -> Status:
        """Submit a new action after a reflex or an exception interrupted the previous one."""
        if not self._counted and self._stuck(ticket, cause):
            reading = self.mission.rule_reading(cause)
            evidence = f"{self._preemptions} pre-emptions without progress, the last by {cause}"
            return self._fail(Failure(Reason.STUCK, evidence + (f" ({reading})" if reading else "")))
        if self.mission.pipeline.held:
            self.feedback_message = f"{ticket.action.name} waits for {self.mission.pipeline.holder or cause}"
            return Status.RUNNING
        self._submit(ticket.action)
        self.replans += 1
        self.feedback_message = f"{ticket.action.name} submitted again after {cause}"
        self.mission.note(Replanned, node=self.mission.path(self), count=self.replans)
        return Status.RUNNING

    def _stuck(self, ticket: Ticket, rule: str) -> bool:
        """Count a pre-emption; returns whether the maximum is exceeded. Progress towards the goal resets the count.

        Rules that wait for something outside of the robot do not count.
        """
        self._counted = True
        if self.mission.rule_waits(rule):
            return False
        left = ticket.action.remaining(self.mission.knowledge)
        if left <= self._nearest - PROGRESS:
            self._nearest, self._preemptions = left, 0
        self._preemptions += 1
        return self._preemptions > self._max_preemptions

    def _fail(self, failure: Failure) -> Status:
        self.failure = failure
        self.feedback_message = str(failure)
        if self.ticket is not None:  # the action may still wait for the end of a reflex
            self.mission.pipeline.cancel(self.ticket, by=self.mission.path(self))
        self._drop_goal()
        return Status.FAILURE

    def _drop_goal(self) -> None:
        """Stop pursuing the action's goal in the world model, which a cancelled action cannot do itself."""
        world = self.mission.knowledge.world
        goal = None if self.ticket is None else getattr(self.ticket.action, "goal", None)
        if goal is not None and world.pursued() == goal:
            world.pursue(None)
