"""Decorators of Nav2 (nav2_behavior_tree, plugins/decorator), which decide how often their child is ticked."""

from __future__ import annotations

import math
from typing import Annotated, Any

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2
from ..plan.context import mission_of
from ..trees.nodes import FAILURE, RUNNING, SUCCESS, Outcome, Output, Syntax
from ..trees.nodes.base_classes import Decorator
from ..trees.value import from_string
from .lenient import Framed, Lenient
from .path import length, poses_in
from .poses import PosesText, PoseText, poses_of, robot_pose, same
from .run_aware import RunAwareDecorator


def _rate(text: str) -> float:
    """Convert a text to a rate [Hz]; raises InputError."""
    rate: float = from_string(text, float)
    if not 0.0 < rate < math.inf:
        raise InputError(Fault(f"a rate must be above 0 Hz, found {text}."))
    return rate


class _Throttled(Lenient, RunAwareDecorator):
    """Base of decorators that tick the child at the beginning of a run, while it is RUNNING, and when it is due.

    In all other ticks the decorator returns RUNNING.
    """

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._first = True

    def tick_once(self) -> Outcome:
        if self.begins():
            self._first = True
            self.restart()
        self.status = RUNNING
        if not (self._first or self.decorated.status is RUNNING or self.due()):
            return RUNNING
        self._first = False
        outcome = self.tick_child()
        if outcome is SUCCESS:
            self.restart()
        if outcome is SUCCESS or outcome is FAILURE:
            self.status = outcome
        return outcome

    def restart(self) -> None:
        """Begin a new interval, after a tick of the child that succeeded, or at the beginning of a run."""
        raise NotImplementedError

    def due(self) -> bool:
        """Whether the interval is over and the child must be ticked again."""
        raise NotImplementedError

    def wait_text(self) -> str:
        running = self.status is not RUNNING or self.decorated.status is RUNNING
        return "" if running else f"ticks its child again {self.next_tick()}"

    def next_tick(self) -> str:
        """Event after which the child is ticked again, with its values."""
        raise NotImplementedError


class RateController(_Throttled):
    """Ticks its child at most at a rate; a RUNNING child is ticked until it ends. RUNNING in between."""

    hz: Annotated[float, Syntax(_rate), "rate [Hz], above 0"] = 10.0

    def restart(self) -> None:
        self._since = self.runtime.now()

    def due(self) -> bool:
        return (self.runtime.now() - self._since + 1e-9) * self.hz >= 1.0

    def next_tick(self) -> str:
        return f"at {self._since + 1.0 / self.hz:.2f} s"


class DistanceController(Framed, _Throttled):
    """Ticks its child each time the robot has moved by a distance. RUNNING in between."""

    distance: Annotated[float, "distance from the position of the child's last tick [m]"] = 1.0

    def restart(self) -> None:
        self._at = robot_pose(mission_of(self))

    def due(self) -> bool:
        moved = self._moved()
        return math.isnan(moved) or moved >= self.distance

    def next_tick(self) -> str:
        return f"after {self.distance:.3g} m, moved {self._moved():.1f} m"

    def _moved(self) -> float:
        return robot_pose(mission_of(self)).distance(self._at)


class GoalWatch(Lenient):
    """Base of nodes that compare the goal with that of a reference state."""

    goal: Annotated[PoseText, "goal; the key `goal` by default"] = None
    goals: Annotated[PosesText, "goals; the key `goals` by default"] = None

    def restart(self) -> None:
        self._goals = self.present()

    def changed(self) -> bool:
        """Whether the goal differs from that of the reference state."""
        return not same(self.present(), self._goals)

    def present(self) -> list[Pose2 | None]:
        """Current poses of the goals."""
        mission = mission_of(self)
        goal, goals = value_of(self, "goal"), value_of(self, "goals")
        return poses_of(mission, [goal] if goal is not None else []) + poses_of(mission, goals or [])


class SpeedController(GoalWatch, _Throttled):
    """Ticks its child at a rate that increases with the robot's speed, and at once when the goal changes."""

    min_rate: Annotated[float, Syntax(_rate), "rate at `min_speed` [Hz], above 0"] = 0.1
    max_rate: Annotated[float, Syntax(_rate), "rate at `max_speed` [Hz], above 0"] = 1.0
    min_speed: Annotated[float, "speed for `min_rate` [m/s]"] = 0.0
    max_speed: Annotated[float, "speed for `max_rate` [m/s]"] = 0.5

    def restart(self) -> None:
        super().restart()
        self._since = self.runtime.now()

    def due(self) -> bool:
        elapsed = self.runtime.now() - self._since + 1e-9
        return self.changed() or elapsed * self._present_rate() >= 1.0

    def next_tick(self) -> str:
        return f"at {self._since + 1.0 / self._present_rate():.1f} s at this speed, or with a new goal"

    def _present_rate(self) -> float:
        """Rate at the robot's speed [Hz]."""
        mission = mission_of(self)
        speed = abs(mission.knowledge.robot.speed(mission.clock.now()))
        low, high = self.min_speed, max(self.max_speed, self.min_speed + 1e-9)
        share = 0.0 if math.isnan(speed) else min(max((speed - low) / (high - low), 0.0), 1.0)
        return float(self.min_rate + share * (self.max_rate - self.min_rate))


class GoalUpdatedController(GoalWatch, _Throttled):
    """Ticks its child at the beginning and each time the goal changes. RUNNING in between."""

    def due(self) -> bool:
        return self.changed()

    def next_tick(self) -> str:
        return "with a new goal"


class SingleTrigger(RunAwareDecorator):
    """Ticks its child until the child ends, then returns FAILURE in each later tick of the run."""

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._armed = True

    def tick_once(self) -> Outcome:
        if self.begins():
            self._armed = True
        self.status = RUNNING
        if not self._armed:
            self.status = FAILURE
            return FAILURE
        outcome = self.tick_child()
        if outcome is SUCCESS or outcome is FAILURE:
            self._armed = False
            self.status = outcome
        return outcome


class GoalUpdater(Lenient, Decorator):
    """Copies the goal to its outputs and ticks its child. There is no topic here: to move the goal, move its node."""

    input_goal: Annotated[PoseText, "goal"] = None
    input_goals: Annotated[PosesText, "goals"] = None
    output_goal: Annotated[Output[Any], "same goal"]
    output_goals: Annotated[Output[Any], "same goals"]

    def tick_once(self) -> Outcome:
        self.status = RUNNING
        for name in ("goal", "goals"):
            if (value := self.goal(name)) is not None:
                self.write(f"output_{name}", value)
        outcome = self.tick_child()
        if outcome is SUCCESS or outcome is FAILURE:
            self.status = outcome
        return outcome

    def goal(self, name: str) -> Any:
        """Present `goal` or `goals`; None without a value."""
        return value_of(self, f"input_{name}")


class PathLongerOnApproach(Lenient, RunAwareDecorator):
    """Ticks its child if the path has become much longer, and the old one was short (near the goal); else SUCCESS."""

    path: Annotated[Any, "path"] = "{path}"
    prox_len: Annotated[float, "maximum length of the old path [m]"] = 3.0
    length_factor: Annotated[float, "minimum ratio of the lengths"] = 2.0

    def tick_once(self) -> Outcome:
        if self.begins():
            self._old: list[Pose2] = []
        path, old = poses_in(self.path), self._old
        longer = False
        if path and old and len(path) != len(old) and path[-1][:2] == old[-1][:2]:
            before = length(old)
            longer = before < self.prox_len and length(path) > self.length_factor * before
        self.status = RUNNING
        if self.decorated.status is RUNNING or longer:
            outcome = self.tick_child()
            if outcome is RUNNING:
                return outcome
        else:
            outcome = SUCCESS
        self._old = path
        if outcome is SUCCESS or outcome is FAILURE:
            self.status = outcome
        return outcome


def value_of(node: Any, port: str) -> Any:
    """Value of a port; if the document gives none, the value of the blackboard key of the port's name; else None."""
    key = node.key(port) or ("" if port in node.given else port)
    if key:
        entry = node.board.entry(key)
        return None if entry is None else entry.value
    return node.read(port)
