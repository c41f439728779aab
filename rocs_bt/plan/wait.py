"""Wait: a leaf that lets time pass, on the agent's own clock."""

from __future__ import annotations

from py_trees.common import Status

from ..clock import Clock
from ..trees.nodes import Leaf


class Wait(Leaf):
    """RUNNING for some time, then SUCCESS. Unlike py_trees' Timer it reads the injected clock, so runs repeat.

    Args:
        name: What displays call it.
        duration: For how long [s].
        clock: Time.
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
        # A nanosecond forgives the rounding of k * step.
        return Status.SUCCESS if self._clock.now() >= self._until - 1e-9 else Status.RUNNING
