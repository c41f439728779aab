"""Exceptions of content in a running agent.

The robot brakes, the exception is reported, and the plan is asked again from the current state. The third exception
within 10 s fails the mission. A reflex whose action raises stops the robot until the latch of its rule clears, a
reactive model until it no longer raises.
"""

from __future__ import annotations

import threading
from collections import deque

from ..clock import Clock
from ..event import EventSink
from ..pipeline import Pipeline
from ..plan import Plan
from ..raised import Raised

LIMIT = 3
"""Exceptions within `WINDOW` that fail the mission."""

WINDOW = 10.0
"""Time within which exceptions are counted [s]."""

_OF_REFLEXES = {
    "reflex action": "stops until the latch of the rule clears",
    "reactive model": "stops until the model no longer raises",
}
"""What is done about the exceptions that the reflex arc answers, by kind."""

_SLACK = 1e-9  # [s] by which sums of periods may miss a time


class ContentExceptions:
    """Takes the exceptions that leaves, planners and actions of one agent raise; safe under threads.

    Args:
        agent: Name of the agent.
        pipeline: Its NORMAL actions are cancelled, so that the robot brakes. An active reflex goes on.
        plan: Asked again from the current state.
        clock: Time.
        sink: Takes the ContentRaised events.

    Attributes:
        failure: Reason of the mission's failure; empty until content raised beyond the limit.
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
        """Brake first, then report the exception, then ask the plan again or fail the mission.

        The exception of a reactive model or of a reflex's action is reported and not counted: the reflex arc stops the
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
        """The agent is stopped: later exceptions are reported and not counted."""
        self._closed = True

    def _report(self, raised: Raised, effect: str) -> None:
        self._sink.emit(raised.event(self._clock.now(), self._agent, effect))

    def _count(self, raised: Raised) -> str:
        """Count an exception, and say what is done about it."""
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
                return f"brakes and asks the plan again ({count})"
            self.failure = f"{raised}; {LIMIT} exceptions within {WINDOW:g} s"
            return f"the mission fails ({count})"
