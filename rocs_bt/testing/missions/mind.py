"""A mission's surroundings without a robot: a clock that stands still, what is known, signals at will."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias

from ...action import Action
from ...actions import action_table
from ...clock import SimulatedClock
from ...errors import InputError
from ...event import ListSink
from ...expression import Environment, compile_expression
from ...geometry import Pose2
from ...knowledge import Knowledge
from ...pipeline import Pipeline
from ...plan import Content, Mission
from ...signal import Signal
from ...units import ANGLE, LENGTH, NONE, SPEED, TURN_RATE, Dimension, parse_quantity

Known: TypeAlias = "Mapping[str, Any] | Callable[[Knowledge], None]"
"""Nodes by name: a pose (x, y) or (x, y, yaw) of a goal, or all attributes with `kind`; or what writes them."""

SIGNALS: Mapping[str, tuple[Dimension, ...]] = {
    **dict.fromkeys(("front", "left_gap", "right_gap", "rear", "stop_distance", "goal_distance"), (LENGTH,)),
    "speed": (SPEED,),
    "turn_rate": (TURN_RATE,),
    "pose": (LENGTH, LENGTH, ANGLE),
}
"""The standard signals; those that a test does not give are invalid, but for a robot at rest at the origin."""

_REST = {"pose": [0.0, 0.0, 0.0], "speed": 0.0, "turn_rate": 0.0}


class Surroundings:
    """What a `Mission` needs, without a robot.

    Args:
        knowledge: What is known at the start.
        signals: Values by signal: `"0.4 m"`, a list of such, or SI numbers.
        step: How long a tick is [s].
        actions: Actions besides the shipped ones.
        content: The node classes and route planners that there are by name.
        name: The mission's name.

    Attributes:
        clock: Time; it moves a step a tick.
        mission: The mission.
        sink: All events.
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
        _tell(self.knowledge, knowledge)
        environment = Environment.of(self.knowledge.signals)
        self.mission = Mission(
            name,
            knowledge=self.knowledge,
            pipeline=Pipeline(self.clock, self.sink, "R1"),
            actions=action_table(*actions),
            compile_guard=lambda text: compile_expression(text, environment),
        )
        self.mission.content = content


def _tell(knowledge: Knowledge, known: Known) -> None:
    if callable(known):
        known(knowledge)
        return
    for name, what in known.items():
        if isinstance(what, Mapping):
            given = dict(what)
            if "pose" in given:
                given["pose"] = Pose2(*given["pose"])
            knowledge.graph.add(name, given.pop("kind", "goal"), **given)
        else:
            knowledge.world.place(name, Pose2(*what), kind="goal")


def _numbers(value: Any) -> list[float]:
    """A value, or several, in SI units."""
    several: Sequence[Any] = value if isinstance(value, (list, tuple)) else [value]
    return [parse_quantity(v).value if isinstance(v, str) else float(v) for v in several]


def _dimension(value: Any) -> Dimension:
    first = value[0] if isinstance(value, (list, tuple)) and value else value
    return parse_quantity(first).dimension if isinstance(first, str) else NONE


def checked_ticks(ticks: int) -> int:
    """How often a mission may be ticked.

    Raises:
        InputError: Not even once.
    """
    if ticks < 1:
        raise InputError(f"a mission is ticked once at least, found {ticks} ticks.")
    return ticks
