"""Baseline planners, which any useful planner must beat."""

from dataclasses import dataclass, field

import numpy as np

from rocs_bt import PositiveMetresPerSecond, PositiveSeconds
from rocs_bt.plan import Observation, Task


class StandStill:
    """Planner that never moves."""

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Store the number of wheels."""
        self._speeds = [0.0] * len(task.locomotion.values)

    def act(self, observation: Observation) -> list[float]:
        """Return zero speeds."""
        return self._speeds


@dataclass(kw_only=True)
class RandomSpeeds:
    """Planner that samples random wheel speeds and holds each sample for a time; done at any goal.

    Attributes:
        speed: Maximum wheel linear speed.
        hold: Time for which each sample is held.
    """

    speed: PositiveMetresPerSecond = 0.5
    hold: PositiveSeconds = 1.0
    _until: float = field(default=0.0, init=False)

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Reset the state."""
        self._task, self._rng, self._until = task, rng, 0.0
        self._speeds = [0.0] * len(task.locomotion.values)

    def act(self, observation: Observation) -> list[float] | None:
        """Hold the current speeds, or sample new ones."""
        near = self._task.tolerances
        if any(observation.pose.distance(goal) <= near[name] for name, goal in self._task.goals.items()):
            return None
        if observation.t >= self._until:
            self._until = observation.t + self.hold
            self._speeds = self._rng.uniform(-self.speed, self.speed, len(self._speeds)).tolist()
        return self._speeds
