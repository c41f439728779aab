"""Analysers that pass on changes of position, orientation, ranges and messages to Plan (paper, 4.2)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from ..base.errors import InputError
from ..base.geometry import wrap_angle
from ..base.units import PositiveMetres, Radians
from ..event import Change
from ..interfaces.channel import Signals, Stamped
from .analyze import Analyze


class PassPosition(Analyze):
    """Maintains the relation `at` between the robot and goals, and reports arrivals and departures."""

    def expects(self) -> Sequence[str]:
        return ("pose",)

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        sample = _newest_pose(samples)
        if sample is None or not all(map(math.isfinite, sample.value["pose"])):
            return
        x, y, _ = sample.value["pose"]
        graph, robot, world = self.knowledge.graph, self.knowledge.agent, self.knowledge.world
        there = graph.related(robot, "at")
        for goal in world.goals():
            pose = world.pose_of(goal)
            if pose is None:
                continue
            distance = math.hypot(pose.x - x, pose.y - y)
            inside = distance <= float(graph.get(goal, "tolerance"))
            if inside and goal not in there:
                graph.relate(robot, "at", goal)
                yield self.change(sample.t, "arrived", goal, distance=distance)
            elif not inside and goal in there:
                graph.unrelate(robot, "at", goal)
                yield self.change(sample.t, "left", goal, distance=distance)


class PassOrientation(Analyze):
    """Reports a heading that differs by more than `step` from the last reported one.

    Attributes:
        step: Heading change that triggers a Change [rad].
    """

    step: Radians = math.radians(45.0)

    def __post_init__(self) -> None:
        self._reported: float | None = None

    def expects(self) -> Sequence[str]:
        return ("pose",)

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        sample = _newest_pose(samples)
        if sample is None or not math.isfinite(yaw := sample.value["pose"][2]):
            return
        if self._reported is None:
            self._reported = yaw
        elif abs(wrap_angle(yaw - self._reported)) > self.step:
            self._reported = yaw
            yield self.change(sample.t, "turned", self.knowledge.agent, yaw=yaw)


class PassRange(Analyze):
    """Keeps an `object` node for each beam group with a near obstacle, and reports when it appears or clears.

    Attributes:
        groups: Names of the beam groups.
        near: Range below which an obstacle is near [m].
        clear: Range above which it is no longer near [m]; above `near` as hysteresis.

    Raises:
        InputError: near is not below clear.
    """

    groups: tuple[str, ...] = ("front", "rear")
    near: PositiveMetres = 0.6
    clear: PositiveMetres = 0.8

    def __post_init__(self) -> None:
        if not self.near < self.clear:
            raise InputError(f"near must be below clear, found {self.near:g} m and {self.clear:g} m.")

    def expects(self) -> Sequence[str]:
        return self.groups

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        graph, robot = self.knowledge.graph, self.knowledge.agent
        sample = samples[-1]
        for group in self.groups:
            if group not in sample.value:
                continue
            distance = min(sample.value[group])
            node = f"something {group}"
            known = graph.has(node)
            if not known and distance < self.near:
                graph.add(node, "object", distance=distance)
                graph.relate(robot, "near", node)
                yield self.change(sample.t, "obstacle", node, distance=distance)
            elif known and distance > self.clear:
                graph.remove(node)
                yield self.change(sample.t, "clear", node, distance=distance)


class PassMessages(Analyze):
    """Reports each received message: a Change of kind `message` about its sender, with its text."""

    def __post_init__(self) -> None:
        self._reported = 0

    def expects(self) -> Sequence[str]:
        return ("messages",)

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        graph = self.knowledge.graph
        for sample in samples:
            if "messages" not in sample.value or math.isnan(sample.value["messages"][0]):
                continue
            while self._reported < sample.value["messages"][0]:
                self._reported += 1
                node = f"message {self._reported}"
                if graph.has(node):  # otherwise the monitor has dropped it: too many messages at once
                    message = graph.attributes(node)
                    yield self.change(sample.t, "message", message["sender"], text=message["text"], node=node)


def _newest_pose(samples: Sequence[Stamped[Signals]]) -> Stamped[Signals] | None:
    """Newest sample with a pose, or None."""
    for sample in reversed(samples):
        if "pose" in sample.value:
            return sample
    return None
