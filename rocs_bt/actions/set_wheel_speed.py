"""SetWheelSpeed: the smallest thing a wheeled robot can do (paper, Table 2)."""

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
    """Turn the wheels at given rim speeds, commanded anew each period, for a time or until something holds.

    With neither `duration` nor `until` it goes on until it is cancelled. A duration is rounded to whole periods, at
    least one; the last of them is commanded and succeeds at once, so the next action begins in the period after.

    Attributes:
        speeds: Rim speeds in the drive's order, left then right for two wheels [m/s].
        duration: For how long [s].
        until: Asked before each command; true ends it.
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
            wanted = f"the drive takes {len(wheels)} rim speeds ({', '.join(wheels)})"
            yield "speeds", f"{wanted}, found {len(speeds)}"

    @classmethod
    def can_move(cls, parameters: Mapping[str, Any]) -> bool:
        return any(parameters.get("speeds", (math.nan,)))

    def act(self, body: Body) -> Progress | Failure:
        speeds, wheels = [float(speed) for speed in self.speeds], body.drive.wheels
        if len(speeds) != len(wheels):
            wanted = f"the drive takes {len(wheels)} rim speeds ({', '.join(wheels)})"
            return Failure(Reason.CANNOT, f"{wanted}, found {speeds}")
        now = body.clock.now()
        if self._begun is None:
            self._begun = now
        elapsed = now - self._begun
        if elapsed >= self.duration or (self.until is not None and self.until(body)):
            return Progress.SUCCEEDED
        body.wheels.command(speeds)
        # Half a period forgives the jitter of real time and rounds the duration to whole periods.
        last = elapsed + 1.5 * body.period > self.duration
        return Progress.SUCCEEDED if last else Progress.RUNNING
