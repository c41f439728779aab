"""Pipeline: queue of actions between Plan and the reflexes, which submit them, and Execute (paper, 5.1).

There are two priorities. NORMAL actions are served first in, first out. A HIGH submission cancels every NORMAL ticket,
queued or running, and is served next. While `hold` is on, because a reflex is active, NORMAL tickets wait. Each ticket
ends in exactly one of the states SUCCEEDED, FAILED, CANCELLED, and each change of state emits an event.

The Pipeline also models the planner's latency: NORMAL submissions, updates and cancellations take effect later by the
planning time, so that the robot continues its present action while its planner computes. HIGH actions have no latency.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Mapping
from enum import Enum
from typing import Any

from ..base.clock import Clock
from ..base.errors import InputError, PipelineError
from ..event import EventSink, TicketChanged
from .action import Action, Failure

_SLACK = 1e-9  # [s] tolerance for rounding in sums of periods


class Priority(Enum):
    """Priority of an action: NORMAL for the plan, HIGH for reflexes (paper, 5.1)."""

    NORMAL = 0
    HIGH = 1


class TicketState(Enum):
    """State of the ticket of a submitted action."""

    QUEUED = "QUEUED"
    RUNNING = "RUNNING"
    SUCCEEDED = "SUCCEEDED"
    FAILED = "FAILED"
    CANCELLED = "CANCELLED"

    def __init__(self, value: str) -> None:
        self.done = value not in ("QUEUED", "RUNNING")


class Ticket:
    """Ticket of one submitted action, from which its state can be read at any time; only the Pipeline changes it.

    Attributes:
        number: Number of the ticket, counted from 1 in each pipeline.
        action: Submitted action.
        priority: Priority of the submission.
        by: Name of the submitter: a reflex rule, or the path of a leaf.
        submitted: Time of submission [s].
        due: Earliest time at which Execute may serve the ticket [s]: `submitted` plus the planner's latency.
        state: Current state.
        failure: Reason of the failure; None unless the state is FAILED.
        cancelled_by: Name of the rule, leaf or component that cancelled the ticket; empty unless the state is
            CANCELLED.
        preempted: Whether the ticket was cancelled by a HIGH submission or by `interrupt`.
    """

    def __init__(self, number: int, action: Action, priority: Priority, by: str, submitted: float) -> None:
        self.number = number
        self.action = action
        self.priority = priority
        self.by = by
        self.submitted = self.due = submitted
        self.state = TicketState.QUEUED
        self.failure: Failure | None = None
        self.cancelled_by = ""
        self.preempted = False

    def __repr__(self) -> str:
        return f"<Ticket {self.number} {self.action.name} {self.priority.name} {self.state.name}>"


class Pipeline:
    """Thread-safe action queue of one agent.

    A change of state and its event happen under one lock, so the events have the order of the changes. A decision of
    the plan takes effect in three steps. `submit`, `cancel` and `update` note it with its due time, or without one if
    the latency is measured. `charge`, after the turn, sets the times that are missing, the same for the whole turn, so
    that Execute never runs half of a decision. `settle`, in each period of Execute, applies what is due.

    Args:
        clock: Source of time.
        sink: Sink that receives the TicketChanged events.
        agent: Name of the agent, for the events.
        latency: Planning latency [s]; None if it is measured, and reported to `charge` after each turn of the plan.
    """

    def __init__(self, clock: Clock, sink: EventSink, agent: str = "", *, latency: float | None = 0.0) -> None:
        self.clock = clock
        self.sink = sink
        self._agent = agent
        self._lock = threading.RLock()  # re-entrant: an update with an impossible value fails its ticket
        self._urgent = threading.Condition(self._lock)
        self._high: deque[Ticket] = deque()
        self._normal: deque[Ticket] = deque()
        self._queues = {Priority.HIGH: self._high, Priority.NORMAL: self._normal}
        self._count = 0
        self._held, self._holder = False, ""
        self._preempted: list[Ticket] = []  # NORMAL tickets cancelled by reflexes that are still active
        self._woken = False
        self._latency = latency
        self._uncharged: list[Ticket] = []
        self._cancellations: list[tuple[Ticket, str, float | None]] = []  # NORMAL ticket, canceller, due time [s]
        self._updates: list[tuple[Ticket, Mapping[str, Any], float | None]] = []  # ticket, values, due time [s]

    def submit(self, action: Action, priority: Priority, by: str) -> Ticket:
        """Queue an action.

        Args:
            action: Action; the same object must not be queued or running already.
            priority: Priority. HIGH, for reflexes, cancels all NORMAL tickets and wakes Execute at once.
            by: Name of the submitter: a reflex rule, or the path of a leaf.

        Raises:
            PipelineError: This action object is already queued or running.
        """
        with self._lock:
            if any(t.action is action for q in self._queues.values() for t in q):
                raise PipelineError(
                    f"{action.name} was submitted by '{by}' while the same object is queued or running."
                )
            self._count += 1
            ticket = Ticket(self._count, action, priority, by, self.clock.now())
            if priority is Priority.HIGH:  # cancels and queues under one lock: nothing can be served in between
                self._preempted += self._normal
                self._preempt(by)
            elif self._latency is None:
                ticket.due = math.inf
                self._uncharged.append(ticket)
            else:
                ticket.due += self._latency
            self._queues[priority].append(ticket)
            self._emit(ticket, by)
            if priority is Priority.HIGH:
                self._wake()
            return ticket

    def cancel(self, ticket: Ticket, by: str) -> bool:
        """Cancel a ticket; returns False if it has already ended. Execute stops a running action at once.

        If the planner has a latency, a NORMAL ticket is cancelled after this time, in `settle`. A ticket that a
        reflex has pre-empted then no longer counts in `blocked`.
        """
        with self._lock:
            if ticket.state.done:
                self._preempted = [other for other in self._preempted if other is not ticket]
                return False
            if ticket.priority is Priority.NORMAL and self._latency != 0.0:
                due = None if self._latency is None else self.clock.now() + self._latency
                self._cancellations.append((ticket, by, due))
                return True
            self._end(ticket, TicketState.CANCELLED, by)
            self._wake()
            return True

    def interrupt(self, by: str) -> None:
        """Cancel all NORMAL tickets at once, as a reflex does, but without a HIGH action, so that the robot brakes.

        Args:
            by: Cause, such as an exception of content.
        """
        with self._lock:
            if self._held:
                self._preempted += self._normal
            self._preempt(by)
            self._wake()

    def update(self, ticket: Ticket, parameters: Mapping[str, Any]) -> None:
        """Set parameters of the action of a NORMAL ticket; if the planner has a latency, `settle` does so later.

        The ticket fails with CANNOT if a value is impossible.
        """
        with self._lock:
            due = None if self._latency is None else self.clock.now() + self._latency
            self._updates.append((ticket, parameters, due))
            if self._latency == 0.0:
                self.settle()

    def charge(self, latency: float) -> None:
        """Set the time at which the planner's last decisions take effect, from its measured latency [s]."""
        with self._lock:
            if not (self._uncharged or self._cancellations or self._updates):
                return
            due = self.clock.now() + latency
            for ticket in self._uncharged:
                ticket.due = due
            self._uncharged.clear()
            self._cancellations = [(ticket, by, due if at is None else at) for ticket, by, at in self._cancellations]
            self._updates = [(ticket, given, due if at is None else at) for ticket, given, at in self._updates]

    def settle(self) -> None:
        """Apply the updates and cancellations with an elapsed latency; Execute calls this in each period."""
        if not self._cancellations and not self._updates:  # without the lock: what is added now is applied later
            return
        with self._lock:
            now = self.clock.now() + _SLACK
            updates, cancellations = self._updates, self._cancellations
            self._updates = [each for each in updates if each[2] is None or each[2] > now]
            self._cancellations = [each for each in cancellations if each[2] is None or each[2] > now]
            for ticket, given, at in updates:
                if at is not None and at <= now and not ticket.state.done:
                    self._update(ticket, given)
            for ticket, by, at in cancellations:
                if at is not None and at <= now and not ticket.state.done:
                    self._end(ticket, TicketState.CANCELLED, by)

    def top(self) -> Ticket | None:
        """Ticket that Execute must serve now: the first HIGH one, else the first NORMAL one, if due and not held."""
        with self._lock:
            if self._high:
                return self._high[0]
            if self._normal and not self._held and self._normal[0].due <= self.clock.now() + _SLACK:
                return self._normal[0]
            return None

    def start(self, ticket: Ticket) -> bool:
        """Set a ticket to RUNNING when Execute begins it; returns False if it was cancelled before."""
        with self._lock:
            if ticket.state is TicketState.QUEUED:
                ticket.state = TicketState.RUNNING
                self._emit(ticket, ticket.by)
            return ticket.state is TicketState.RUNNING

    def succeed(self, ticket: Ticket) -> bool:
        """Set a ticket to SUCCEEDED; returns False if it was cancelled before."""
        with self._lock:
            return not ticket.state.done and self._end(ticket, TicketState.SUCCEEDED, ticket.by)

    def fail(self, ticket: Ticket, failure: Failure) -> bool:
        """Set a ticket to FAILED; returns False if it was cancelled before."""
        with self._lock:
            if ticket.state.done:
                return False
            ticket.failure = failure
            return self._end(ticket, TicketState.FAILED, ticket.by)

    def hold(self, held: bool, by: str = "") -> None:
        """Hold NORMAL tickets back, while a reflex of a rule is active, or release them."""
        with self._lock:
            self._held, self._holder = held, by
            if not held:
                self._preempted.clear()

    @property
    def held(self) -> bool:
        """Whether NORMAL tickets are held back."""
        return self._held

    @property
    def holder(self) -> str:
        """Rule that holds NORMAL tickets back; empty if none does."""
        return self._holder

    @property
    def blocked(self) -> bool:
        """Whether an action of the plan, queued or pre-empted by a reflex, waits for the end of the reflex."""
        with self._lock:
            return self._held and bool(self._normal or self._preempted)

    def queued(self) -> tuple[Ticket, ...]:
        """All tickets that have not ended, in the order in which they are served."""
        with self._lock:
            return (*self._high, *self._normal)

    def clear(self, by: str) -> None:
        """Cancel all tickets; `by` is the cause."""
        with self._lock:
            for ticket in self.queued():
                self._end(ticket, TicketState.CANCELLED, by)
            self._wake()

    def wait(self, timeout: float) -> bool:
        """Wait at most `timeout` [s] for a HIGH submission, a cancellation or `wake`; returns whether one occurred."""
        with self._lock:
            called = self._urgent.wait_for(lambda: self._woken, timeout)
            self._woken = False
            return called

    def wake(self) -> None:
        """Wake Execute without a ticket, such as at the end of a run."""
        with self._lock:
            self._wake()

    def _update(self, ticket: Ticket, parameters: Mapping[str, Any]) -> None:
        try:
            ticket.action.update(**parameters)
        except InputError as error:
            self.fail(ticket, Failure.cannot(error))

    def _preempt(self, by: str) -> None:
        for ticket in list(self._normal):
            ticket.preempted = True
            self._end(ticket, TicketState.CANCELLED, by)

    def _wake(self) -> None:
        self._woken = True
        self._urgent.notify_all()

    def _end(self, ticket: Ticket, state: TicketState, by: str) -> bool:
        self._queues[ticket.priority].remove(ticket)
        ticket.state = state
        if state is TicketState.CANCELLED:
            ticket.cancelled_by = by
        self._emit(ticket, by)
        return True

    def _emit(self, ticket: Ticket, by: str) -> None:
        self.sink.emit(
            TicketChanged(
                t=self.clock.now(),
                agent=self._agent,
                ticket=ticket.number,
                action=ticket.action.name,
                parameters=ticket.action.parameters,
                priority=ticket.priority.name,
                state=ticket.state.name,
                by=by,
                reason=str(ticket.failure or ""),
            )
        )
