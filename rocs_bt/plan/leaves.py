"""Leaves other than actions: Condition, Enter and Wait."""

from __future__ import annotations

from collections.abc import Callable

from py_trees.common import Status

from ..clock import Clock
from ..knowledge import Knowledge
from ..trees.nodes import Instant, Leaf


class Condition(Instant):
    """SUCCESS while an expression is true, FAILURE while it is false or invalid; never RUNNING.

    Args:
        name: Name in displays.
        text: Text of the expression.
        holds: Function that returns whether the expression is true.
        reading: Function that returns the current values, such as `min(front) = 0.21 m`; called if the expression is
            not true.
    """

    def __init__(self, name: str, text: str, holds: Callable[[], bool], reading: Callable[[], str]) -> None:
        super().__init__(name)
        self.text = text
        self._holds = holds
        self._reading = reading

    def written(self) -> tuple[str, dict[str, str]]:
        return "When", {"expression": self.text}

    def update(self) -> Status:
        if self._holds():
            self.feedback_message = ""
            return Status.SUCCESS
        self.feedback_message = f"'{self.text}' does not hold: {self._reading()}"
        return Status.FAILURE


class Enter(Instant):
    """Sets the attribute `mode` of the agent's own node; returns SUCCESS.

    Args:
        name: Name in displays.
        mode: Mode, as listed by rules.
        knowledge: Knowledge of the agent.
    """

    def __init__(self, name: str, mode: str, knowledge: Knowledge) -> None:
        super().__init__(name)
        self.mode = mode
        self._knowledge = knowledge

    def written(self) -> tuple[str, dict[str, str]]:
        return "Enter", {"mode": self.mode}

    def update(self) -> Status:
        self._knowledge.graph.set(self._knowledge.agent, mode=self.mode)
        return Status.SUCCESS


class Wait(Leaf):
    """RUNNING for a duration, then SUCCESS. Unlike py_trees' Timer it reads the injected clock, so that runs repeat.

    Args:
        name: Name in displays.
        duration: Duration [s].
        clock: Time source.
    """

    def __init__(self, name: str, duration: float, clock: Clock) -> None:
        super().__init__(name)
        self.duration = duration
        self._clock = clock
        self._until = 0.0

    def written(self) -> tuple[str, dict[str, str]]:
        return "Sleep", {"msec": str(round(self.duration * 1000))}

    def initialise(self) -> None:
        self._until = self._clock.now() + self.duration

    def update(self) -> Status:
        # The tolerance of a nanosecond covers the rounding of k * step.
        return Status.SUCCESS if self._clock.now() >= self._until - 1e-9 else Status.RUNNING
