"""Plan: the block that decides what the robot does next (paper, 4.2, 5.2 and 5.3)."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..action import Action, make_action
from ..channel import AnalyzeSubscriber, Stamped
from ..clock import Clock
from ..event import Change, EventSink
from ..knowledge import Knowledge
from ..pipeline import Pipeline, Priority, Ticket
from ..raised import Raised, from_actuator, owners_of
from .route import RoutePlanner

RUNNING, SUCCESS, FAILURE = "RUNNING", "SUCCESS", "FAILURE"


class Plan(AnalyzeSubscriber, ABC):
    """Planner of one agent: receives the Changes published by Analyze blocks and submits NORMAL actions.

    A user's planner implements `run` (paper, 5.3: a deliberative extension point):

        class Patrol(Plan):
            def run(self, t):
                self.changes()
                if self.ticket is None or self.ticket.state.done:
                    self.ticket = self.submit("GoTo", goal=next(self.round))

    Args:
        name: Name for messages.
        knowledge: Knowledge of the agent.
        pipeline: Pipeline for submitted actions.
        actions: Action table.
        clock: Time source.
        sink: Sink for events.

    Attributes:
        status: `RUNNING`, `SUCCESS` or `FAILURE`.
        reason: Reason of a failure; empty otherwise.
        on_exception: Handler of exceptions in leaves, which are then ticked again; None to raise the exceptions.
    """

    def __init__(
        self,
        name: str,
        *,
        knowledge: Knowledge,
        pipeline: Pipeline,
        actions: Mapping[str, type[Action]],
        clock: Clock,
        sink: EventSink,
    ) -> None:
        super().__init__()
        self.name = name
        self.knowledge = knowledge
        self.pipeline = pipeline
        self.actions = actions
        self.clock = clock
        self.sink = sink
        self.status = RUNNING
        self.reason = ""
        self.on_exception: Callable[[Raised], None] | None = None
        self._lock = threading.Lock()
        self._replan_by: list[str] = []

    @abstractmethod
    def run(self, t: float) -> None:
        """Execute one turn of the planner; called once per period and whenever `called` is true. Must not block.

        Args:
            t: Current time [s].
        """

    @property
    def called(self) -> bool:
        """Whether a Change arrived or a replan was requested since the last call of `changes`."""
        return bool(self._replan_by) or self.inbox.pending

    def replan(self, by: str) -> None:
        """Request an early turn because the plan's assumptions may be wrong, as after a reflex. Thread-safe."""
        with self._lock:
            self._replan_by.append(by)
        self.inbox.wake()

    def changes(self) -> Sequence[Stamped[Change]]:
        """Take the Changes that arrived since the last turn, oldest first; resets `called`."""
        with self._lock:
            self._replan_by.clear()
        return self.inbox.drain()

    def submit(self, action: str, **parameters: Any) -> Ticket:
        """Submit an action with NORMAL priority.

        Args:
            action: Name in the action table.
            parameters: Parameters of the action, in SI units.

        Raises:
            InputError: Unknown action or parameter.
        """
        made = make_action(self.actions, action, parameters)
        return self.pipeline.submit(made, Priority.NORMAL, by=self.name)

    def close(self) -> None:
        """Release the planner's resources; called once at the end of a run."""

    def blame(self, error: BaseException) -> Raised | None:
        """Find the action, route planner or planner that raised an exception.

        Args:
            error: Exception raised in `run` or in `close`, with its traceback.

        Returns:
            Kind and name of the code at fault; None if only rocs_bt itself or an actuator is at fault.
        """
        if from_actuator(error):
            return None
        for owner in owners_of(error):
            if (found := self.content_of(owner)) is not None:
                return Raised.of(*found, error, *self.definitions_of(owner))
        return None

    def content_of(self, owner: object) -> tuple[str, str] | None:
        """Kind, such as `action`, and name of the class whose object this is; None for objects of rocs_bt itself."""
        if isinstance(owner, Action):
            return "action", owner.name
        if isinstance(owner, RoutePlanner):
            return "route planner", type(owner).__name__
        if owner is self and not type(self).__module__.startswith("rocs_bt."):
            return "planner", self.name
        return None

    def definitions_of(self, owner: object) -> tuple[object, ...]:
        """Objects whose source files may contain the fault, for `raised_at`; the object itself first."""
        return (owner,)
