"""PassPosition: at which places the robot is."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from ..channel import Signals, Stamped
from ..event import Change
from .analyze import Analyze


class PassPosition(Analyze):
    """Relates the robot to the goals and places it is `at`, and tells Plan when it arrives at one or leaves it."""

    def expects(self) -> Sequence[str]:
        return ("pose",)

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        sample = next((s for s in reversed(samples) if "pose" in s.value), None)
        if sample is None or not all(map(math.isfinite, sample.value["pose"])):
            return
        x, y = sample.value["pose"][:2]
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
