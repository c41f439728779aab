"""SetWheelSpeed: command wheel linear speeds (paper, Table 2)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

from ..action import AtomicAction, Body, Failure, Progress, Reason
from ..errors import KnowledgeError
from ..units import SPEED, Bounds, Seconds

if TYPE_CHECKING:
    from ..knowledge import Knowledge


@dataclass(kw_only=True, eq=False)
class SetWheelSpeed(AtomicAction):
    """Command wheel linear speeds each period, for a time or until a condition holds.

    Without `duration` and `until` the action runs until it is cancelled. The duration is rounded to whole periods, at
    least one. The action commands and succeeds in the last of them, so the next action begins in the following period.

    Attributes:
        speeds: Wheel linear speeds in the drive's order, left then right for two wheels [m/s].
        duration: Duration [s].
        until: Condition checked before each command; true ends the action.
    """

    speeds: Annotated[Sequence[float], SPEED]
    duration: Annotated[Seconds, Bounds(0.0, infinite=True)] = math.inf
    until: Callable[[Body], bool] | None = None
    _begun: float | None = field(default=None, init=False, repr=False)

    @classmethod
    def misfits(cls, parameters: Mapping[str, Any], knowledge: Knowledge) -> Iterator[tuple[str, str]]:
        try:
            wheels = knowledge.robot.drive.wheels
        except KnowledgeError:  # a robot without wheels, which fails when it acts
            return
        if "speeds" in parameters and len(speeds := parameters["speeds"]) != len(wheels):
            wanted = f"the drive takes {len(wheels)} wheel speeds ({', '.join(wheels)})"
            yield "speeds", f"{wanted}, found {len(speeds)}"

    @classmethod
    def can_move(cls, parameters: Mapping[str, Any]) -> bool:
        return any(parameters.get("speeds", (math.nan,)))

    def act(self, body: Body) -> Progress | Failure:
        speeds, wheels = [float(speed) for speed in self.speeds], body.drive.wheels
        if len(speeds) != len(wheels):
            wanted = f"the drive takes {len(wheels)} wheel speeds ({', '.join(wheels)})"
            return Failure(Reason.CANNOT, f"{wanted}, found {speeds}")
        now = body.clock.now()
        if self._begun is None:
            self._begun = now
        elapsed = now - self._begun
        if elapsed >= self.duration or (self.until is not None and self.until(body)):
            return Progress.SUCCEEDED
        body.wheels.command(speeds)
        # Half a period of tolerance absorbs the jitter of real time and rounds the duration to whole periods.
        last = elapsed + 1.5 * body.period > self.duration
        return Progress.SUCCEEDED if last else Progress.RUNNING
