"""Drive toward each goal of the task, and turn away from near obstacles."""

from dataclasses import dataclass

import numpy as np

from rocs_bt import PositiveMetres, PositiveMetresPerSecond, Twist2
from rocs_bt.plan import Observation, Task


@dataclass(kw_only=True)
class Planner:
    """Drive toward each goal of the task, and turn away from near obstacles.

    Attributes:
        cruise: Maximum speed.
        near: Gap to an obstacle from which on the robot slows down and turns away.
    """

    cruise: PositiveMetresPerSecond = 0.4
    near: PositiveMetres = 0.8

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Begin an episode; use no random numbers except those of `rng`."""
        self._goals = [(pose, task.tolerances[name]) for name, pose in task.goals.items()]

    def act(self, observation: Observation) -> Twist2 | None:
        """Decide on the motion until the next call, a tenth of a second later; None if all goals were reached."""
        pose, signals = observation.pose, observation.signals
        while self._goals and pose.distance(self._goals[0][0]) <= self._goals[0][1]:
            self._goals.pop(0)
        if not self._goals:
            return None
        # Gaps between the robot and the nearest obstacle in three directions [m]; NaN if a sensor is stale.
        ahead, left, right = (float(np.min(signals[name])) for name in ("front", "left_gap", "right_gap"))
        if np.isnan([*pose, ahead, left, right]).any():
            return Twist2(forward=0.0)
        free = min(ahead / self.near, 1.0)
        away = (1.0 - free) * (1.0 if left > right else -1.0)
        bearing = pose.bearing(self._goals[0][0])  # angle from the robot's heading to the goal, left positive [rad]
        turn = float(np.clip(free * bearing + away, -1.0, 1.0))
        return Twist2(forward=self.cruise * free * max(np.cos(bearing), 0.2), turn=turn)
