"""Planners without state: current sensor values determine the wheel speeds."""

from dataclasses import dataclass
from math import cos, hypot, sin

import numpy as np

from rocs_bt import Metres, MetresPerSecond, PositiveMetres, PositiveMetresPerSecond, RadiansPerSecond
from rocs_bt.base.geometry import wrap_angle
from rocs_bt.plan import Observation, Task, Vehicle


@dataclass(kw_only=True)
class Braitenberg:
    """Braitenberg vehicle: range sensors and the bearing of the goal drive the wheels directly.

    Source: Braitenberg, Vehicles (1984), vehicles 2 and 3. The goal acts like a light that attracts the vehicle.

    Attributes:
        cruise: Speed without near obstacles.
        reach: Gap below which obstacles act.
        light: Gain from the goal's bearing to the turn rate [1/s].
        fear: Gain of obstacles at the sides, which turn the robot away from them.
    """

    cruise: PositiveMetresPerSecond = 0.5
    reach: PositiveMetres = 0.8
    light: float = 0.6
    fear: float = 1.2

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Read the robot's properties."""
        self._robot = Vehicle(task)

    def act(self, observation: Observation) -> list[float] | None:
        """Sum the contributions of the sensors."""
        robot, signals = self._robot, observation.signals
        if robot.arrived(observation):
            return None
        left, right, ahead = (self._felt(signals[name]) for name in ("left_gap", "right_gap", "front"))
        _, bearing = robot.to_goal(observation)
        turn = self.light * bearing + self.fear * (right - left) / robot.locomotion.arm * self.cruise
        if ahead > 0.7 and abs(left - right) < 0.1:  # equal obstacles on both sides: turn toward the goal's side
            turn += self.fear * (1.0 if bearing >= 0.0 else -1.0)
        return robot.move(self.cruise * (1.0 - ahead), turn)

    def _felt(self, gaps: np.ndarray) -> float:
        """Proximity of the nearest obstacle, from 0 at a gap of `reach` to 1 at contact; invalid values count as 1."""
        nearest = float(np.min(gaps))
        return 1.0 if nearest != nearest else float(np.clip(1.0 - nearest / self.reach, 0.0, 1.0))


@dataclass(kw_only=True)
class PotentialField:
    """Potential field: follows the sum of the attraction of the goal and the repulsion of obstacles.

    Source: Khatib, Real-time obstacle avoidance for manipulators and mobile robots (IJRR 5, 1986). The attraction grows
    with the distance to the goal up to a limit; the repulsion acts only within `reach`. The robot gets stuck in local
    minima.

    Attributes:
        cruise: Speed without near obstacles.
        reach: Gap from the hull beyond which obstacles do not repel.
        repulsion: Gain of the repulsion relative to the attraction of the goal.
        turn_rate: Maximum turn rate.
    """

    cruise: PositiveMetresPerSecond = 0.8
    reach: PositiveMetres = 0.6
    repulsion: float = 0.02
    turn_rate: RadiansPerSecond = 1.5

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Read the robot's properties."""
        self._robot = Vehicle(task)

    def act(self, observation: Observation) -> list[float] | None:
        """Drive in the direction of the total force."""
        robot = self._robot
        if robot.arrived(observation):
            return None
        if np.isnan(observation.pose.x):
            return robot.stop()
        distance, bearing = robot.to_goal(observation)
        pull = min(distance, 1.0)
        x, y = pull * cos(bearing), pull * sin(bearing)
        points = robot.obstacles(observation.pose, self.reach + robot.footprint.outer)
        gaps = np.maximum(robot.footprint.gap(*points.T), 0.02)
        near = gaps < self.reach
        strength = self.repulsion * (1.0 / gaps[near] - 1.0 / self.reach) / gaps[near] ** 2
        if near.any():
            away = points[near] / np.hypot(*points[near].T)[:, None]
            push = -(strength[:, None] * away).sum(axis=0) / near.sum()  # the mean: independent of the cell size
            x, y = x + float(push[0]), y + float(push[1])
        heading = float(np.arctan2(y, x))
        speed = self.cruise * max(cos(heading), 0.0) * min(hypot(x, y), 1.0)
        return robot.move(speed, float(np.clip(2.0 * wrap_angle(heading), -self.turn_rate, self.turn_rate)))


@dataclass(kw_only=True)
class FiniteStateMachine:
    """Bug algorithm: drives toward the goal; at an obstacle, follows its edge until the robot is nearer and can go on.

    Source: Bug 2 of Lumelsky and Stepanov, Path-planning strategies for a point mobile automaton (Algorithmica 2,
    1987). Along an edge, the turn rate is proportional to the deviation of the gap from `keep`. The obstacle is always
    on the right.

    Attributes:
        cruise: Speed toward the goal.
        edge: Speed along an edge.
        stop: Gap ahead below which edge following begins.
        keep: Gap kept to the obstacle on the right.
    """

    cruise: PositiveMetresPerSecond = 0.6
    edge: MetresPerSecond = 0.35
    stop: PositiveMetres = 0.5
    keep: Metres = 0.3

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Begin by driving toward the goal."""
        self._robot, self._state, self._left_at = Vehicle(task), "to the goal", 0.0

    def act(self, observation: Observation) -> list[float] | None:
        """Change the state if necessary, and return the wheel speeds of the state."""
        robot, signals = self._robot, observation.signals
        if robot.arrived(observation):
            return None
        ahead, right = float(np.min(signals["front"])), float(np.min(signals["right_gap"]))
        distance, bearing = robot.to_goal(observation)
        if np.isnan(ahead + right) or np.isnan(distance):
            return robot.stop()
        if self._state == "to the goal" and ahead < self.stop and distance > self.stop:
            self._state, self._left_at = "along an edge", distance
        free = ahead > 1.2 * self.stop and abs(bearing) < 1.0
        if self._state == "along an edge" and free and distance < self._left_at - 0.1:
            self._state = "to the goal"
        if self._state == "to the goal":
            turn = float(np.clip(2.0 * bearing, -1.5, 1.5))
            return robot.move(self.cruise * max(cos(bearing), 0.0), turn)
        if ahead < self.stop:
            return robot.move(0.0, 1.0)
        return robot.move(self.edge, float(np.clip(2.0 * (self.keep - right), -1.0, 1.0)))
