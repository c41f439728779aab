"""The Pipeline: the action queue between Plan or the reflexes and Execute (paper, 5.1; docs/architecture.md).

There are two priorities. NORMAL is first in, first out. A HIGH submission cancels every NORMAL ticket, queued or
running, and is served next. While `hold` is on (a reflex is active), NORMAL tickets wait undecomposed. Nothing is
dropped silently: each ticket ends in exactly one of SUCCEEDED, FAILED, CANCELLED, and each change emits an event.

The Pipeline also applies a planner's latency. NORMAL submissions, updates and cancellations take effect that much
later, so the robot continues its present action while its planner thinks. HIGH actions have no latency.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Mapping
from enum import Enum
from typing import Any

from .action import Action, Failure
from .clock import Clock
from .errors import InputError, PipelineError
from .event import EventSink, TicketChanged

_SLACK = 1e-9  # [s] tolerance for rounding in sums of periods


class Priority(Enum):
    """The two priorities of the paper."""

    NORMAL = 0
    HIGH = 1


class TicketState(Enum):
    """State of a submitted action.

    Attributes:
        done: Whether the state is final.
    """

    QUEUED = "QUEUED"
    RUNNING = "RUNNING"
    SUCCEEDED = "SUCCEEDED"
    FAILED = "FAILED"
    CANCELLED = "CANCELLED"

    def __init__(self, value: str) -> None:
        self.done = value not in ("QUEUED", "RUNNING")


class Ticket:
    """Receipt of one submitted action, readable at any time; only the Pipeline changes it.

    Attributes:
        number: Number of the ticket, counted from 1 in each pipeline.
        action: Submitted action.
        priority: Priority of the submission.
        by: Submitter: a rule or a leaf of the tree.
        submitted: Time of submission [s].
        due: Earliest time at which Execute may serve the ticket [s]: `submitted` plus the planner's latency.
        state: Current state.
        failure: Cause of the failure; None unless FAILED.
        cancelled_by: Canceller of the ticket; empty unless CANCELLED.
        preempted: Whether it was cancelled by a HIGH submission, or by `interrupt`.
    """

    __slots__ = (
        "action", "by", "cancelled_by", "due", "failure", "number", "preempted", "priority", "state", "submitted",
    )  # fmt: skip  # a table

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

    Args:
        clock: Source of time.
        sink: Receiver of the ticket events.
        agent: The agent's name, for the events.
        latency: Planning time [s]; None if it is measured and reported to `charge` after each tick of the plan.
    """

    def __init__(self, clock: Clock, sink: EventSink, agent: str = "", *, latency: float | None = 0.0) -> None:
        self.clock = clock
        self.sink = sink
        self._agent = agent
        self._lock = threading.RLock()
        self._urgent = threading.Condition(self._lock)
        self._high: deque[Ticket] = deque()
        self._normal: deque[Ticket] = deque()
        self._queues = {Priority.HIGH: self._high, Priority.NORMAL: self._normal}
        self._count = 0
        self._held = False
        self._preempted: list[Ticket] = []  # NORMAL tickets cancelled by reflexes that are still active
        self._woken = False
        self._latency = latency
        self._uncharged: list[Ticket] = []
        self._cancellations: list[tuple[Ticket, str, float | None]] = []  # NORMAL ticket, canceller, due time [s]
        self._updates: list[tuple[Ticket, Mapping[str, Any], float | None]] = []  # ticket, values, due time [s]

    def submit(self, action: Action, priority: Priority, by: str) -> Ticket:
        """Queue an action.

        Args:
            action: Action object; it must not be queued or running already.
            priority: HIGH for reflexes: cancels all NORMAL tickets and wakes Execute at once.
            by: Submitter: a rule or a leaf of the tree.

        Raises:
            PipelineError: This action object is already in the queue.
        """
        with self._lock:
            if any(t.action is action for q in self._queues.values() for t in q):
                raise PipelineError(
                    f"{action.name} was submitted by '{by}' while the same object is queued or running."
                )
            self._count += 1
            ticket = Ticket(self._count, action, priority, by, self.clock.now())
            if priority is Priority.HIGH:
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
        """Cancel a ticket; False if it had already ended. Execute stops a running action at once.

        Cancelling a ticket that a reflex cut off removes it from `blocked`. If the planner has a latency, `settle`
        cancels NORMAL tickets that much later.
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
        """Cancel all NORMAL tickets at once, as a reflex does but without a HIGH action: the robot brakes.

        Args:
            by: Cause, such as an exception raised by content.
        """
        with self._lock:
            if self._held:
                self._preempted += self._normal
            self._preempt(by)
            self._wake()

    def update(self, ticket: Ticket, parameters: Mapping[str, Any]) -> None:
        """Give a NORMAL ticket's action new parameters; `settle` applies them if the planner has a latency.

        The ticket fails (CANNOT) if a value is impossible.
        """
        with self._lock:
            due = None if self._latency is None else self.clock.now() + self._latency
            self._updates.append((ticket, parameters, due))
            if self._latency == 0.0:
                self.settle()

    def charge(self, latency: float) -> None:
        """Set the due time of the planner's last decisions from its measured latency [s]."""
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
        """Apply updates and cancellations that are due after the planner's latency; Execute calls this each period."""
        if not self._cancellations and not self._updates:
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
        """The ticket for Execute to serve now: the first HIGH one, else the first NORMAL one if due and not held."""
        with self._lock:
            if self._high:
                return self._high[0]
            if self._normal and not self._held and self._normal[0].due <= self.clock.now() + _SLACK:
                return self._normal[0]
            return None

    def start(self, ticket: Ticket) -> bool:
        """Set a ticket RUNNING when Execute begins it; False if it was cancelled before."""
        with self._lock:
            if ticket.state is TicketState.QUEUED:
                ticket.state = TicketState.RUNNING
                self._emit(ticket, ticket.by)
            return ticket.state is TicketState.RUNNING

    def succeed(self, ticket: Ticket) -> bool:
        """Set a ticket SUCCEEDED; False if it was cancelled before."""
        with self._lock:
            return not ticket.state.done and self._end(ticket, TicketState.SUCCEEDED, ticket.by)

    def fail(self, ticket: Ticket, failure: Failure) -> bool:
        """Set a ticket FAILED; False if it was cancelled before."""
        with self._lock:
            if ticket.state.done:
                return False
            ticket.failure = failure
            return self._end(ticket, TicketState.FAILED, ticket.by)

    def hold(self, held: bool) -> None:
        """Suspend the NORMAL tickets (a reflex is active), or release them."""
        with self._lock:
            self._held = held
            if not held:
                self._preempted.clear()

    @property
    def held(self) -> bool:
        """Whether NORMAL tickets wait."""
        return self._held

    @property
    def blocked(self) -> bool:
        """Whether a plan action, queued or cut off by a reflex, waits for the end of that reflex."""
        with self._lock:
            return self._held and bool(self._normal or self._preempted)

    def queued(self) -> tuple[Ticket, ...]:
        """All tickets that have not ended, in serving order."""
        with self._lock:
            return (*self._high, *self._normal)

    def clear(self, by: str) -> None:
        """Cancel all tickets."""
        with self._lock:
            for ticket in self.queued():
                self._end(ticket, TicketState.CANCELLED, by)
            self._wake()

    def wait(self, timeout: float) -> bool:
        """Wait at most `timeout` [s] for a HIGH submission, a cancellation or `wake`; True if one occurred."""
        with self._lock:
            called = self._urgent.wait_for(lambda: self._woken, timeout)
            self._woken = False
            return called

    def wake(self) -> None:
        """Wake Execute without a ticket, as at the end of a run."""
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
