"""Analysers that pass on to Plan what changed: position, orientation, ranges and messages (paper, 4.2)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from ..channel import Signals, Stamped
from ..errors import InputError
from ..event import Change
from ..geometry import wrap_angle
from .analyze import Analyze


class PassPosition(Analyze):
    """Relates the robot to the goals and places it is `at`, and tells Plan when it arrives at one or leaves it."""

    def expects(self) -> Sequence[str]:
        return ("pose",)

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        sample = _newest_pose(samples)
        if sample is None or not all(map(math.isfinite, sample.value["pose"])):
            return
        x, y, _ = sample.value["pose"]
        graph, robot, world = self.knowledge.graph, self.knowledge.agent, self.knowledge.world
        there = graph.related(robot, "at")
        for place in world.goals():
            pose = world.pose_of(place)
            if pose is None:
                continue
            distance = math.hypot(pose.x - x, pose.y - y)
            inside = distance <= float(graph.get(place, "tolerance"))
            if inside and place not in there:
                graph.relate(robot, "at", place)
                yield self.change(sample.t, "arrived", place, distance=distance)
            elif not inside and place in there:
                graph.unrelate(robot, "at", place)
                yield self.change(sample.t, "left", place, distance=distance)


class PassOrientation(Analyze):
    """Tells Plan when the heading differs by more than `step` from the one it told last.

    Args:
        step: The difference that matters [rad].
    """

    def __init__(self, *args: Any, step: float = math.radians(45.0), **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._step = step
        self._told: float | None = None

    def expects(self) -> Sequence[str]:
        return ("pose",)

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        sample = _newest_pose(samples)
        if sample is None or not math.isfinite(yaw := sample.value["pose"][2]):
            return
        if self._told is None:
            self._told = yaw
        elif abs(wrap_angle(yaw - self._told)) > self._step:
            self._told = yaw
            yield self.change(sample.t, "turned", self.knowledge.agent, yaw=yaw)


class PassRange(Analyze):
    """Keeps one `object` node per group of beams in the graph while something is near on it, and tells Plan.

    Args:
        groups: The groups to look at.
        near: Closer than this is near [m].
        clear: Farther than this is no longer near [m]; above `near`, so that it does not flicker.
    """

    def __init__(
        self,
        *args: Any,
        groups: Sequence[str] = ("front", "rear"),
        near: float = 0.6,
        clear: float = 0.8,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        if not 0.0 < near < clear < math.inf:
            raise InputError(f"near must be above 0 m and below clear, found {near:g} m and {clear:g} m.")
        self._groups = tuple(groups)
        self._near = near
        self._clear = clear

    def expects(self) -> Sequence[str]:
        return self._groups

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        graph, robot = self.knowledge.graph, self.knowledge.agent
        sample = samples[-1]
        for group in self._groups:
            if group not in sample.value:
                continue
            distance = min(sample.value[group])
            node = f"something {group}"
            known = graph.has(node)
            if not known and distance < self._near:
                graph.add(node, "object", distance=distance)
                graph.relate(robot, "near", node)
                yield self.change(sample.t, "obstacle", node, distance=distance)
            elif known and distance > self._clear:
                graph.remove(node)
                yield self.change(sample.t, "clear", node, distance=distance)


class PassMessages(Analyze):
    """Tells Plan of each message that has come: a Change of kind `message` about its sender, with its text."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._told = 0

    def expects(self) -> Sequence[str]:
        return ("messages",)

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        graph = self.knowledge.graph
        for sample in samples:
            if "messages" not in sample.value or math.isnan(sample.value["messages"][0]):
                continue
            while self._told < sample.value["messages"][0]:
                self._told += 1
                node = f"message {self._told}"
                if graph.has(node):  # else it is among the oldest of too many at once
                    said = graph.attributes(node)
                    yield self.change(sample.t, "message", said["sender"], text=said["text"], node=node)


def _newest_pose(samples: Sequence[Stamped[Signals]]) -> Stamped[Signals] | None:
    """The newest sample with a pose."""
    for sample in reversed(samples):
        if "pose" in sample.value:
            return sample
    return None
