"""SetTwist: command a body twist; `hold` commands any body."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from ..base.errors import KnowledgeError
from ..base.geometry import Twist2, Twist3
from ..base.units import Bounds, MetresPerSecond, RadiansPerSecond, Seconds
from ..interfaces.action import Action, AtomicAction, Body, Failure, Progress, Reason
from .set_wheel_speed import HoldTimer, SetWheelSpeed

if TYPE_CHECKING:
    from ..knowledge import Knowledge

_AXES = {"forward": "vx", "left": "vy", "up": "vz", "turn": "wz"}
"""Axis of the locomotion, by parameter."""


class SetTwist(AtomicAction):
    """Command a body twist each period, for a time or until a condition holds.

    It is the smallest motion of any body; bodies on wheels have SetWheelSpeed too. Without `duration` and `until` the
    action runs until it is cancelled. The duration is rounded to whole periods, at least one.

    Attributes:
        forward: Forward speed [m/s].
        left: Lateral speed, left positive [m/s].
        up: Vertical speed [m/s].
        turn: Turn rate, left positive [rad/s].
        duration: Duration [s].
        until: Condition checked before each command; true ends the action.
    """

    forward: MetresPerSecond = 0.0
    left: MetresPerSecond = 0.0
    up: MetresPerSecond = 0.0
    turn: RadiansPerSecond = 0.0
    duration: Annotated[Seconds, Bounds(0.0, infinite=True)] = math.inf
    until: Callable[[Body], bool] | None = None

    def __post_init__(self) -> None:
        self._timer = HoldTimer()

    @classmethod
    def misfits(cls, parameters: Mapping[str, Any], knowledge: Knowledge) -> Iterator[tuple[str, str]]:
        try:
            axes, kind = knowledge.robot.locomotion.axes, knowledge.robot.locomotion.kind
        except KnowledgeError:
            return
        for name, axis in _AXES.items():
            if parameters.get(name, 0.0) != 0.0 and axis not in axes:
                yield name, _missing(kind, axis)

    @classmethod
    def can_move(cls, parameters: Mapping[str, Any]) -> bool:
        return any(parameters.get(name, 0.0) != 0.0 for name in _AXES)

    def act(self, body: Body) -> Progress | Failure:
        locomotion = body.locomotion
        for name, axis in _AXES.items():
            if getattr(self, name) != 0.0 and axis not in locomotion.axes:
                return Failure(Reason.CANNOT, _missing(locomotion.kind, axis))
        if self._timer.over(body, self.duration, self.until):
            return Progress.SUCCEEDED
        body.move(Twist3(self.forward, self.left, self.up, self.turn))
        return self._timer.progress(body, self.duration)


def hold(
    body: Body, values: Sequence[float], duration: float = math.inf, until: Callable[[Body], bool] | None = None
) -> Action:
    """Action that holds the values of a motion command: SetWheelSpeed on wheels, SetTwist on other bodies.

    Args:
        body: Robot.
        values: Values of the command, as in `body.locomotion.values`.
        duration: Duration [s].
        until: Condition that ends the action.
    """
    if body.locomotion.wheels:
        return SetWheelSpeed(speeds=list(values), duration=duration, until=until)
    twist = body.locomotion.twist3(values)
    return SetTwist(
        forward=twist.forward, left=twist.left, up=twist.up, turn=twist.turn, duration=duration, until=until
    )


def hold_twist(
    body: Body,
    twist: Twist2 | Twist3,
    duration: float = math.inf,
    until: Callable[[Body], bool] | None = None,
) -> Action:
    """Action that holds a body twist; arguments as in `hold`."""
    return hold(body, body.locomotion.command(twist).tolist(), duration, until)


def _missing(kind: str, axis: str) -> str:
    directions = {"vx": "forward", "vy": "sideways", "vz": "up or down", "wz": "in a turn"}
    return f"a '{kind}' locomotion cannot move {directions[axis]} by command"
