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
    """One agent's planner. It takes the Changes that Analyze blocks publish and submits NORMAL actions.

    A user's planner implements `run` (paper, 5.3: a deliberative extension point):

        class Patrol(Plan):
            def run(self, t):
                self.changes()
                if self.ticket is None or self.ticket.state.done:
                    self.ticket = self.submit("GoTo", goal=next(self.round))

    Args:
        name: What messages call it.
        knowledge: All that the robot knows.
        pipeline: Where actions are submitted.
        actions: The action table.
        clock: Time.
        sink: Where events go.

    Attributes:
        status: `RUNNING`, `SUCCESS` or `FAILURE`.
        reason: Why it failed; empty unless it did.
        on_exception: Takes the exceptions of leaves that are ticked on; None to raise them instead.
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
        """One turn; called when its period is due and whenever it is `called`. Must not block.

        Args:
            t: Now [s].
        """

    @property
    def called(self) -> bool:
        """Whether a Change arrived or somebody asked for a new plan since `changes` was read last."""
        return bool(self._replan_by) or self.inbox.pending

    def replan(self, by: str) -> None:
        """Ask for a turn soon: the world is not what the plan took it for, as after a reflex. Any thread may."""
        with self._lock:
            self._replan_by.append(by)
        self.inbox.wake()

    def changes(self) -> Sequence[Stamped[Change]]:
        """Take the Changes that arrived since the last turn, oldest first; answers the call."""
        with self._lock:
            self._replan_by.clear()
        return self.inbox.drain()

    def submit(self, action: str, **parameters: Any) -> Ticket:
        """Submit an action with NORMAL priority.

        Args:
            action: Its name in the action table.
            parameters: Its parameters, in SI units.

        Raises:
            InputError: No such action or parameter.
        """
        made = make_action(self.actions, action, parameters)
        return self.pipeline.submit(made, Priority.NORMAL, by=self.name)

    def close(self) -> None:
        """Let go of what the planner holds; called once at the end of a run."""

    def blame(self, error: BaseException) -> Raised | None:
        """The content that raised an exception in a turn or in `close`; None if only the engine or an actuator did.

        Args:
            error: The exception, with its traceback.
        """
        if from_actuator(error):
            return None
        for owner in owners_of(error):
            if (found := self.content_of(owner)) is not None:
                return Raised.of(*found, error, *self.definitions_of(owner))
        return None

    def content_of(self, owner: object) -> tuple[str, str] | None:
        """Kind and name of the content that an object is; None if it is none."""
        if isinstance(owner, Action):
            return "action", owner.name
        if isinstance(owner, RoutePlanner):
            return "route planner", type(owner).__name__
        if owner is self and not type(self).__module__.startswith("rocs_bt."):
            return "planner", self.name
        return None

    def definitions_of(self, owner: object) -> tuple[object, ...]:
        """Where content is defined, for `raised_at`: the object itself, then what else locates it."""
        return (owner,)
