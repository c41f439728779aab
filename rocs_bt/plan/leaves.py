"""Leaves other than actions: Condition, Enter and Wait."""

from __future__ import annotations

from collections.abc import Callable

from py_trees.common import Status

from ..base.clock import Clock
from ..knowledge import Knowledge
from ..trees.nodes import Instant, Leaf


class Condition(Instant):
    """Leaf that returns SUCCESS while an expression is true, and FAILURE while it is false or invalid.

    Args:
        name: Name in displays.
        text: Text of the expression.
        holds: Function that returns whether the expression is true.
        reading: Function that returns a text with the values in the expression, such as `min(front) = 0.21 m`; it is
            called if the expression is not true.
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
            return Status.SUCCESS
        self.feedback_message = f"'{self.text}' does not hold: {self._reading()}"
        return Status.FAILURE

    def wait_text(self) -> str:
        return f"{self.text}, {self._reading()}"


class Enter(Instant):
    """Leaf that sets the mode of the agent and returns SUCCESS.

    The mode is an attribute of the agent's own node in the knowledge graph.
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
    """Leaf that is RUNNING for a duration, then returns SUCCESS.

    Unlike py_trees' Timer, it reads the agent's clock, so that runs are repeatable.

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

    def wait_text(self) -> str:
        return f"until {self._until:.2f} s" if self.status is Status.RUNNING else ""
