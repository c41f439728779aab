"""SetWheelSpeed: command wheel linear speeds (paper, Table 2)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from ..base.errors import KnowledgeError
from ..base.units import SPEED, Bounds, Seconds
from ..interfaces.action import AtomicAction, Body, Failure, Progress, Reason

if TYPE_CHECKING:
    from ..control.locomotion import Locomotion
    from ..knowledge import Knowledge


@dataclass
class HoldTimer:
    """Timer of an action that commands the same motion for a time or until a condition holds."""

    _begun: float | None = None

    def over(self, body: Body, duration: float, until: Callable[[Body], bool] | None) -> bool:
        """Whether the action has ended before this period: the time is over [s], or the condition holds."""
        now = body.clock.now()
        if self._begun is None:
            self._begun = now
        return now - self._begun >= duration or (until is not None and until(body))

    def progress(self, body: Body, duration: float) -> Progress:
        """Progress after the command of this period; the action succeeds in its last period."""
        elapsed = body.clock.now() - (self._begun or 0.0)
        # Half a period of tolerance absorbs the jitter of real time and rounds the duration to whole periods.
        return Progress.SUCCEEDED if elapsed + 1.5 * body.period > duration else Progress.RUNNING


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

    def __post_init__(self) -> None:
        self._timer = HoldTimer()

    @classmethod
    def misfits(cls, parameters: Mapping[str, Any], knowledge: Knowledge) -> Iterator[tuple[str, str]]:
        try:
            locomotion = knowledge.robot.locomotion
        except KnowledgeError:
            return
        if "speeds" in parameters and (wrong := _misfit(locomotion, parameters["speeds"], len(parameters["speeds"]))):
            yield "speeds", wrong

    @classmethod
    def can_move(cls, parameters: Mapping[str, Any]) -> bool:
        return any(parameters.get("speeds", (math.nan,)))

    def act(self, body: Body) -> Progress | Failure:
        speeds = [float(speed) for speed in self.speeds]
        if wrong := _misfit(body.locomotion, speeds, speeds):
            return Failure(Reason.CANNOT, wrong)
        if self._timer.over(body, self.duration, self.until):
            return Progress.SUCCEEDED
        body.motion.command(speeds)
        return self._timer.progress(body, self.duration)


def _misfit(locomotion: Locomotion, speeds: Sequence[float], found: object) -> str:
    """Reason why wheel speeds do not fit a locomotion, with what was found; empty if they do."""
    wheels = locomotion.wheels
    if not wheels:
        return f"a '{locomotion.kind}' locomotion has no wheels; use SetTwist"
    wanted = f"the drive takes {len(wheels)} wheel speeds ({', '.join(wheels)})"
    return "" if len(speeds) == len(wheels) else f"{wanted}, found {found}"
