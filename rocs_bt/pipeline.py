"""The Pipeline: the queue between whoever wants something done and Execute (paper, 5.1; docs/architecture.md).

Two priorities. NORMAL is first in, first out. A HIGH submission cancels every NORMAL ticket, queued or running, and is
next. While `hold` is on (a reflex is active) NORMAL tickets wait, undecomposed. Nothing is ever dropped silently:
each ticket ends in exactly one of SUCCEEDED, FAILED, CANCELLED, and each change is an event.
"""

from __future__ import annotations

import threading
from collections import deque
from enum import Enum

from .action import Action, Failure
from .clock import Clock
from .errors import PipelineError
from .event import EventSink, TicketChanged


class Priority(Enum):
    """The two priorities of the paper."""

    NORMAL = 0
    HIGH = 1


class TicketState(Enum):
    """Where an action is on its way.

    Attributes:
        done: Whether this is an end.
    """

    QUEUED = "QUEUED"
    RUNNING = "RUNNING"
    SUCCEEDED = "SUCCEEDED"
    FAILED = "FAILED"
    CANCELLED = "CANCELLED"

    def __init__(self, value: str) -> None:
        self.done = value not in ("QUEUED", "RUNNING")


class Ticket:
    """The receipt of one submitted action. Read it at any time; only the Pipeline changes it.

    Attributes:
        number: Counted from 1 in each pipeline.
        action: What was submitted.
        priority: How.
        by: By whom.
        submitted: When [s].
        state: Where it is now.
        failure: Why it failed; None unless FAILED.
        cancelled_by: Who cancelled it; empty unless CANCELLED.
        preempted: Whether it was cancelled by a HIGH submission.
    """

    __slots__ = (
        "action", "by", "cancelled_by", "failure", "number", "preempted", "priority", "state", "submitted",
    )  # fmt: skip

    def __init__(self, number: int, action: Action, priority: Priority, by: str, submitted: float) -> None:
        self.number = number
        self.action = action
        self.priority = priority
        self.by = by
        self.submitted = submitted
        self.state = TicketState.QUEUED
        self.failure: Failure | None = None
        self.cancelled_by = ""
        self.preempted = False

    def __repr__(self) -> str:
        return f"<Ticket {self.number} {self.action.name} {self.priority.name} {self.state.name}>"


class Pipeline:
    """One agent's queue of actions; safe under threads.

    Args:
        clock: Where time is read.
        sink: Where ticket events go.
        agent: The agent's name, for the events.
    """

    def __init__(self, clock: Clock, sink: EventSink, agent: str = "") -> None:
        self._clock = clock
        self._sink = sink
        self._agent = agent
        self._lock = threading.RLock()
        self._urgent = threading.Condition(self._lock)
        self._high: deque[Ticket] = deque()
        self._normal: deque[Ticket] = deque()
        self._queues = {Priority.HIGH: self._high, Priority.NORMAL: self._normal}
        self._count = 0
        self._held = False
        self._woken = False

    def submit(self, action: Action, priority: Priority, by: str) -> Ticket:
        """Queue an action.

        Args:
            action: The action; an object of its own, never submitted before.
            priority: HIGH for reflexes: cancels all NORMAL tickets, and wakes Execute at once.
            by: Who asks: a rule, or a leaf of the tree.

        Raises:
            PipelineError: This action object is already in the queue.
        """
        with self._lock:
            if any(t.action is action for q in self._queues.values() for t in q):
                raise PipelineError(
                    f"{action.name} was submitted by '{by}' while the same object is queued or running."
                )
            self._count += 1
            ticket = Ticket(self._count, action, priority, by, self._clock.now())
            if priority is Priority.HIGH:
                for waiting in list(self._normal):
                    waiting.preempted = True
                    self._end(waiting, TicketState.CANCELLED, by)
            self._queues[priority].append(ticket)
            self._emit(ticket, by)
            if priority is Priority.HIGH:
                self._wake()
            return ticket

    def cancel(self, ticket: Ticket, by: str) -> bool:
        """Take a ticket back; False if it had ended already. A running action is stopped by Execute, at once."""
        with self._lock:
            if ticket.state.done:
                return False
            self._end(ticket, TicketState.CANCELLED, by)
            self._wake()
            return True

    def top(self) -> Ticket | None:
        """The ticket that Execute must serve now: the first HIGH one, else (unless held) the first NORMAL one."""
        with self._lock:
            if self._high:
                return self._high[0]
            if self._normal and not self._held:
                return self._normal[0]
            return None

    def start(self, ticket: Ticket) -> bool:
        """Execute begins with this ticket; False if it was cancelled in the meantime."""
        with self._lock:
            if ticket.state is TicketState.QUEUED:
                ticket.state = TicketState.RUNNING
                self._emit(ticket, ticket.by)
            return ticket.state is TicketState.RUNNING

    def succeed(self, ticket: Ticket) -> bool:
        """Execute has done it; False if it was cancelled in the meantime."""
        with self._lock:
            return not ticket.state.done and self._end(ticket, TicketState.SUCCEEDED, ticket.by)

    def fail(self, ticket: Ticket, failure: Failure) -> bool:
        """Execute could not do it; False if it was cancelled in the meantime."""
        with self._lock:
            if ticket.state.done:
                return False
            ticket.failure = failure
            return self._end(ticket, TicketState.FAILED, ticket.by)

    def hold(self, held: bool) -> None:
        """Let NORMAL tickets wait (a reflex is active), or go on."""
        with self._lock:
            self._held = held

    @property
    def held(self) -> bool:
        """Whether NORMAL tickets wait."""
        return self._held

    def queued(self) -> tuple[Ticket, ...]:
        """All tickets that have not ended, in the order in which they would be served."""
        with self._lock:
            return (*self._high, *self._normal)

    def clear(self, by: str) -> None:
        """Cancel everything."""
        with self._lock:
            for ticket in self.queued():
                self._end(ticket, TicketState.CANCELLED, by)
            self._wake()

    def wait(self, timeout: float) -> bool:
        """Wait until a HIGH submission or a cancellation calls, at most `timeout` [s]; True if one did."""
        with self._lock:
            called = self._urgent.wait_for(lambda: self._woken, timeout)
            self._woken = False
            return called

    def wake(self) -> None:
        """Wake Execute without a ticket, as at the end of a run."""
        with self._lock:
            self._wake()

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
        self._sink.emit(
            TicketChanged(
                t=self._clock.now(),
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
