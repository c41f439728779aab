"""Environment of a mission without a robot: a clock that only the test advances, initial knowledge, given signals."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias

from ...actions import action_table
from ...base.clock import SimulatedClock
from ...base.errors import InputError
from ...base.geometry import Pose2
from ...base.signal import Signal
from ...base.units import ANGLE, LENGTH, NONE, SPEED, TURN_RATE, Dimension, parse_quantity
from ...event import ListSink
from ...expression import Environment, compile_expression
from ...interfaces.action import Action
from ...interfaces.pipeline import Pipeline
from ...knowledge import Knowledge
from ...plan import Content, Mission

Known: TypeAlias = "Mapping[str, Any] | Callable[[Knowledge], None]"
"""Initial knowledge: nodes by name, or a function that writes them.

A node is the pose (x, y) or (x, y, yaw) of a goal, or all its attributes with `kind`.
"""

SIGNALS: Mapping[str, tuple[Dimension, ...]] = {
    **dict.fromkeys(("front", "left_gap", "right_gap", "rear", "stop_distance", "goal_distance"), (LENGTH,)),
    "speed": (SPEED,),
    "turn_rate": (TURN_RATE,),
    "pose": (LENGTH, LENGTH, ANGLE),
}
"""Standard signals. Those not given by the test are invalid, except that the robot is at rest at the origin."""

_REST = {"pose": [0.0, 0.0, 0.0], "speed": 0.0, "turn_rate": 0.0}


class MissionEnvironment:
    """Builds a `Mission` without a robot.

    Args:
        knowledge: Initial knowledge.
        signals: Value of each signal: a text with a unit such as `"0.4 m"`, a number in SI units, or a list of these.
        step: Time per tick [s].
        actions: Actions in addition to the shipped ones.
        content: Source of node classes and route planners.
        name: Name of the mission.

    Attributes:
        clock: Clock; advances one step per tick.
        mission: The mission.
        sink: Sink with all events.
    """

    def __init__(
        self,
        knowledge: Known,
        signals: Mapping[str, Any],
        *,
        step: float,
        actions: Iterable[type[Action]],
        content: Content,
        name: str,
    ) -> None:
        self.clock, self.sink = SimulatedClock(step), ListSink()
        self.knowledge = Knowledge("R1", self.clock, self.sink)
        values = {**_REST, **signals}
        for signal, dimensions in {**dict.fromkeys(values, None), **SIGNALS}.items():
            numbers = _numbers(values.get(signal, [math.nan] * len(dimensions or "1")))
            kinds = dimensions or (_dimension(values[signal]),)
            self.knowledge.signals.declare(Signal(signal, len(numbers), kinds))
        self.knowledge.signals.freeze()
        for signal, value in values.items():
            self.knowledge.signals.write(signal, _numbers(value), 0.0)
        _add(self.knowledge, knowledge)
        environment = Environment.of(self.knowledge.signals)
        self.mission = Mission(
            name,
            knowledge=self.knowledge,
            pipeline=Pipeline(self.clock, self.sink, "R1"),
            actions=action_table(*actions),
            compile_guard=lambda text: compile_expression(text, environment),
        )
        self.mission.content = content


def _add(knowledge: Knowledge, known: Known) -> None:
    if callable(known):
        known(knowledge)
        return
    for name, value in known.items():
        if isinstance(value, Mapping):
            given = dict(value)
            if "pose" in given:
                given["pose"] = Pose2(*given["pose"])
            knowledge.graph.add(name, given.pop("kind", "goal"), **given)
        else:
            knowledge.world.place(name, Pose2(*value), kind="goal")


def _numbers(value: Any) -> list[float]:
    """Convert one value or a list of values to numbers in SI units."""
    several: Sequence[Any] = value if isinstance(value, (list, tuple)) else [value]
    return [parse_quantity(v).value if isinstance(v, str) else float(v) for v in several]


def _dimension(value: Any) -> Dimension:
    first = value[0] if isinstance(value, (list, tuple)) and value else value
    return parse_quantity(first).dimension if isinstance(first, str) else NONE


def checked_ticks(ticks: int) -> int:
    """Return the number of ticks if it is valid.

    Raises:
        InputError: The number is less than 1.
    """
    if ticks < 1:
        raise InputError(f"ticks must be at least 1, found {ticks}.")
    return ticks
