"""Handling of exceptions that content raises in a running agent.

The robot brakes, the exception is reported, and the plan replans from the present state. The third exception within
10 s fails the mission. If the action of a reflex raises, the robot stops until the rule is released. If a reactive
model raises, the robot stops until the model no longer raises.
"""

from __future__ import annotations

import threading
from collections import deque

from ..base.clock import Clock
from ..base.raised import Raised
from ..event import ContentRaised, EventSink
from ..interfaces.pipeline import Pipeline
from ..plan import Plan

LIMIT = 3
"""Number of exceptions within `WINDOW` at which the mission fails."""

WINDOW = 10.0
"""Time window in which exceptions are counted [s]."""

_OF_REFLEXES = {
    "reflex action": "stops until the latch of the rule clears",
    "reactive model": "stops until the model no longer raises",
}
"""Reaction to exceptions that the reflex arc handles, by the kind of the content; for events."""

_SLACK = 1e-9  # [s] rounding tolerance of summed periods


class ContentExceptions:
    """Handler of the exceptions that leaves, planners and actions of one agent raise; thread-safe.

    After an exception the NORMAL actions are cancelled, an active reflex continues, and the plan replans. `failure` is
    empty until the limit is reached.
    """

    def __init__(self, agent: str, pipeline: Pipeline, plan: Plan, clock: Clock, sink: EventSink) -> None:
        self.failure = ""
        self._agent = agent
        self._pipeline = pipeline
        self._plan = plan
        self._clock = clock
        self._sink = sink
        self._lock = threading.Lock()
        self._times: deque[float] = deque()
        self._closed = False

    def take(self, raised: Raised) -> None:
        """Brake, report the exception, then replan or fail the mission.

        Exceptions of reactive models and of reflex actions are reported but not counted: the reflex arc stops the
        robot.
        """
        if (effect := _OF_REFLEXES.get(raised.kind)) is not None:
            self._report(raised, effect)
            return
        name = f"the exception of {raised.kind} '{raised.content}'"
        self._pipeline.interrupt(by=name)
        self._report(raised, self._count(raised))
        if not self.failure:
            self._plan.replan(name)

    def close(self) -> None:
        """Stop counting: exceptions after the agent's stop are only reported."""
        self._closed = True

    def _report(self, raised: Raised, effect: str) -> None:
        self._sink.emit(ContentRaised.of(self._clock.now(), self._agent, raised, effect))

    def _count(self, raised: Raised) -> str:
        """Count an exception; returns a text about the reaction to it."""
        now = self._clock.now()
        with self._lock:
            if self._closed:
                return "none: the run is over"
            if self.failure:
                return "none: the mission has failed"
            while self._times and self._times[0] < now - WINDOW - _SLACK:
                self._times.popleft()
            self._times.append(now)
            count = f"{len(self._times)} of {LIMIT} within {WINDOW:g} s"
            if len(self._times) < LIMIT:
                return f"brakes and replans ({count})"
            self.failure = f"{raised}; {LIMIT} exceptions within {WINDOW:g} s"
            return f"the mission fails ({count})"
