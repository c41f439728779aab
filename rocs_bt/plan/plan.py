"""Plan: block of MAPE-K that decides what the robot does next (paper, 4.2, 5.2 and 5.3)."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..base.clock import Clock
from ..base.raised import Raised, from_actuator, owners_of
from ..event import Change, EventSink
from ..interfaces.action import Action, make_action
from ..interfaces.channel import AnalyzeSubscriber, Stamped
from ..interfaces.pipeline import Pipeline, Priority, Ticket
from ..knowledge import Knowledge
from .context import MissionContext
from .route import RoutePlanner

RUNNING, SUCCESS, FAILURE = "RUNNING", "SUCCESS", "FAILURE"


class Plan(AnalyzeSubscriber, ABC):
    """Base class of planners of one agent.

    A planner receives the Changes that Analyze blocks publish, and submits actions with NORMAL priority. A user's
    planner implements `run` (paper, 5.3: a deliberative extension point):

        class Patrol(Plan):
            def run(self, t):
                self.changes()
                if self.ticket is None or self.ticket.state.done:
                    self.ticket = self.submit("GoTo", goal=next(self.round))

    Args:
        name: Name of the planner, for messages.
        knowledge: Knowledge of the agent.
        pipeline: Pipeline for submitted actions.
        actions: Actions of the agent, keyed by name.
        clock: Time source.
        sink: Sink that receives the planner's events.

    Attributes:
        status: `RUNNING`, `SUCCESS` or `FAILURE`.
        reason: Reason of the failure; empty unless the status is `FAILURE`.
        on_exception: Handler of exceptions in leaves; a leaf that raised is ticked again. None to raise the exceptions.
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
        """Execute one turn of the planner: once per period, and whenever `called` is true. It must not block.

        Args:
            t: Current time [s].
        """

    @classmethod
    def idle(cls, mission: MissionContext) -> Plan:
        """Mission that does nothing."""
        return _Idle(mission.name, **mission.parts)

    @property
    def called(self) -> bool:
        """Whether a Change has arrived, or a replan was requested, since the last call of `changes`."""
        return bool(self._replan_by) or self.inbox.pending

    @property
    def running(self) -> str:
        """What the mission is doing and for how long, such as `GoTo(dock) has run for 12.0 s`; empty if unknown."""
        return ""

    def replan(self, by: str) -> None:
        """Request an early turn because the plan's assumptions may be wrong, such as after a reflex. Thread-safe.

        Args:
            by: Name of the rule or component that requests it.
        """
        with self._lock:
            self._replan_by.append(by)
        self.inbox.wake()

    def changes(self) -> Sequence[Stamped[Change]]:
        """Take the Changes that have arrived since the last turn, oldest first. This resets `called`."""
        with self._lock:
            self._replan_by.clear()
        return self.inbox.drain()

    def submit(self, action: str, **parameters: Any) -> Ticket:
        """Submit an action with NORMAL priority.

        Args:
            action: Name of the action in the action table.
            parameters: Parameters of the action, in SI units.

        Raises:
            InputError: The action or a parameter is unknown.
        """
        made = make_action(self.actions, action, parameters)
        return self.pipeline.submit(made, Priority.NORMAL, by=self.name)

    def close(self) -> None:
        """Release the planner's resources; called once at the end of a run."""

    def blame(self, error: BaseException) -> Raised | None:
        """Find the user's action, route planner or planner that raised an exception.

        Args:
            error: Exception raised in `run` or in `close`, with its traceback.

        Returns:
            Exception with the kind and name of the content that raised it; None if rocs_bt itself or an actuator did.
        """
        if from_actuator(error):
            return None
        for owner in owners_of(error):
            if (found := self.content_of(owner)) is not None:
                return Raised.of(*found, error, *self.definitions_of(owner))
        return None

    def content_of(self, owner: object) -> tuple[str, str] | None:
        """Kind, such as `action`, and name of the content to which an object belongs; None for objects of rocs_bt."""
        if isinstance(owner, Action):
            return "action", owner.name
        if isinstance(owner, RoutePlanner):
            return "route planner", type(owner).__name__
        if owner is self and not type(self).__module__.startswith("rocs_bt."):
            return "planner", self.name
        return None

    def definitions_of(self, owner: object) -> tuple[object, ...]:
        """Objects with source files that may contain the fault, the given object first; see `raised_at`."""
        return (owner,)


class _Idle(Plan):
    def run(self, t: float) -> None:
        self.changes()
