"""Lower bounds: what a planner must beat to be worth anything."""

from dataclasses import dataclass, field

import numpy as np

from rocs_bt.plan import Observation, Task
from rocs_bt.units import PositiveMetresPerSecond, PositiveSeconds


class StandStill:
    """Never moves."""

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Note how many wheels there are."""
        self._speeds = [0.0] * len(task.drive.wheels)

    def act(self, observation: Observation) -> list[float]:
        """Stand."""
        return self._speeds


@dataclass(kw_only=True)
class RandomSpeeds:
    """Random wheel speeds, each held for a time; it holds itself to have arrived when it happens to be at a goal.

    Attributes:
        speed: The greatest rim speed.
        hold: For how long a draw is held.
    """

    speed: PositiveMetresPerSecond = 0.5
    hold: PositiveSeconds = 1.0
    _until: float = field(default=0.0, init=False)

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Begin anew."""
        self._task, self._rng, self._until = task, rng, 0.0
        self._speeds = [0.0] * len(task.drive.wheels)

    def act(self, observation: Observation) -> list[float] | None:
        """Draw, or hold what was drawn."""
        near = self._task.tolerances
        if any(observation.pose.distance(goal) <= near[name] for name, goal in self._task.goals.items()):
            return None
        if observation.t >= self._until:
            self._until = observation.t + self.hold
            self._speeds = self._rng.uniform(-self.speed, self.speed, len(self._speeds)).tolist()
        return self._speeds
