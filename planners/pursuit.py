"""Planners that follow a way by looking a little ahead on it."""

from dataclasses import dataclass
from math import hypot, inf

import numpy as np

from rocs_bt.errors import Fault, InputError
from rocs_bt.plan import NoRoute, Observation, Task, Vehicle
from rocs_bt.units import PositiveMetres, PositiveMetresPerSecond, RadiansPerSecond


@dataclass(kw_only=True)
class PurePursuit:
    """Plans a way with a route planner, anew at each look, and steers at a point of it ahead.

    Source: Coulter, Implementation of the pure pursuit path tracking algorithm (CMU-RI-TR-92-01, 1992). It slows down
    where something is ahead, and stands where there is no way.

    Attributes:
        planner: A file of planners/routes.
        cruise: The fastest.
        look: How far ahead the point is.
        clearance: The room that a way must have.
        turn_rate: The fastest turn.
    """

    planner: str = "grid_astar"
    cruise: PositiveMetresPerSecond = 0.8
    look: PositiveMetres = 0.5
    clearance: PositiveMetres = 0.05
    turn_rate: RadiansPerSecond = 1.5

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Make the route planner."""
        self._robot, self._routes = Vehicle(task), task.route(self.planner)

    def act(self, observation: Observation) -> list[float] | None:
        """Plan, and steer."""
        robot, pose = self._robot, observation.pose
        if robot.arrived(observation):
            return None
        if np.isnan(pose.x):
            return robot.stand()
        try:
            way = self._routes.route(pose, robot.goal, self.clearance)
        except NoRoute:
            return robot.stand()
        return steered(robot, observation, way, self.look, self.cruise, self.turn_rate)


@dataclass(kw_only=True)
class Oracle:
    """Knows the true map: follows a shortest way through all that stands there. An upper bound, and no planner.

    What moves it does not know. Only planners that say `oracle = true` are told, and only by scenes of a family.

    Attributes:
        cruise: The fastest.
        look: How far ahead the point is that it steers at.
        clearance: The room beside its outline's circle that the way has, where there is such a way.
        turn_rate: The fastest turn.
    """

    cruise: PositiveMetresPerSecond = 1.0
    look: PositiveMetres = 0.35
    clearance: PositiveMetres = 0.05
    turn_rate: RadiansPerSecond = 2.0

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Plan the way once."""
        if "ground" not in task.privileged:
            raise InputError(Fault("an oracle needs a scene that tells its ground, found none.", hint="Take a family."))
        self._robot, self._grid, self._way = Vehicle(task), task.privileged["ground"].grid(0.05), None

    def act(self, observation: Observation) -> list[float] | None:
        """Steer along it."""
        robot = self._robot
        if robot.arrived(observation):
            return None
        if np.isnan(observation.pose.x):
            return robot.stand()
        if self._way is None:
            self._way = self._shortest(observation)
        return steered(robot, observation, self._way, self.look, self.cruise, self.turn_rate)

    def _shortest(self, observation: Observation) -> list[tuple[float, float]]:
        """The way with the most room of a few that are asked for."""
        robot, start = self._robot, observation.pose[:2]
        widest, narrowest = robot.footprint.outer + self.clearance, robot.footprint.inner
        for radius in np.linspace(widest, narrowest, 5):
            way = self._grid.shortest(start, robot.goal[:2], float(radius))
            if way is not None:
                return list(way.points)
        return [start, robot.goal[:2]]


def steered(
    robot: Vehicle, observation: Observation, way: list[tuple[float, float]], look: float, cruise: float, fastest: float
) -> list[float]:
    """Rim speeds that lead to the point of a way that is a distance ahead [m], along an arc."""
    pose = observation.pose
    ahead, aside = robot.ahead(pose, way, look)
    distance = hypot(ahead, aside)
    if ahead <= 0.3 * distance:  # it lies beside or behind
        return robot.wheels(0.0, float(np.copysign(min(fastest, 1.0), aside)))
    curvature = 2.0 * aside / max(distance, 1e-6) ** 2
    straight = np.column_stack([np.linspace(0.0, 1.2, 7), np.zeros(7), np.zeros(7)])
    gaps = robot.gaps(pose, 2.0, straight) if robot.maps else np.full(7, inf)
    room = straight[:, 0][gaps < 0.05]
    speed = min(cruise, max(0.15, float(room[0]) if len(room) else inf), fastest / max(abs(curvature), 1e-6))
    return robot.wheels(speed, speed * curvature)
