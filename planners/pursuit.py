"""Path-following planners with a lookahead point."""

from dataclasses import dataclass
from math import hypot, inf

import numpy as np

from rocs_bt import (
    Fault,
    InputError,
    MetresPerSecond,
    PositiveMetres,
    PositiveMetresPerSecond,
    PositiveSeconds,
    RadiansPerSecond,
)
from rocs_bt.plan import NoRoute, Observation, Task, Vehicle


@dataclass(kw_only=True)
class PurePursuit:
    """Pure pursuit: replans the path at each step and steers toward a lookahead point on it.

    Source: Coulter, Implementation of the pure pursuit path tracking algorithm (CMU-RI-TR-92-01, 1992). The robot slows
    down for obstacles ahead and stops if there is no path.

    Attributes:
        planner: Route planner: name of a file in planners/routes.
        cruise: Maximum speed.
        look: Lookahead distance.
        clearance: Minimum gap between the hull and obstacles along the path.
        turn_rate: Maximum turn rate.
        movers: Whether the robot slows down and stops for predicted movers.
        horizon: Time to a predicted contact below which a speed is too high.
        comfort: Gap to a mover that counts as contact.
        back: Maximum speed in reverse, with which the robot leaves a mover that comes toward it.
    """

    planner: str = "grid_astar"
    cruise: PositiveMetresPerSecond = 0.8
    look: PositiveMetres = 0.5
    clearance: PositiveMetres = 0.05
    turn_rate: RadiansPerSecond = 1.5
    movers: bool = False
    horizon: PositiveSeconds = 2.0
    comfort: PositiveMetres = 0.1
    back: MetresPerSecond = 0.0

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Create the route planner."""
        self._robot, self._routes = Vehicle(task, movers=self.movers), task.route(self.planner)
        self._routes.moving = not self.movers

    def act(self, observation: Observation) -> list[float] | None:
        """Plan and steer."""
        robot, pose = self._robot, observation.pose
        if robot.arrived(observation):
            return None
        if np.isnan(pose.x):
            return robot.stop()
        try:
            path = self._routes.route(pose, robot.goal, self.clearance)
            command = steered(robot, observation, path, self.look, self.cruise, self.turn_rate)
        except NoRoute:  # such as after a push against a pillar, from which a robot among movers backs off
            command = robot.move(-0.3, 0.0) if self.movers else robot.stop()
        return [self._share(observation, command) * value for value in command] if self.movers else command

    def _share(self, observation: Observation, command: list[float]) -> float:
        """Largest share of a command without a contact within the horizon; else that with the latest contact."""
        robot = self._robot
        twist, ahead = robot.locomotion.twist(np.array(command)), np.linspace(0.0, self.horizon, 11)[1:]
        shares = np.append(np.linspace(-self.back / self.cruise, 0.0, 3)[:-1], np.linspace(0.0, 1.0, 6))
        driven = shares[:, None] * ahead
        half = 0.5 * twist.turn * driven
        chord = twist.forward * driven * np.sinc(half / np.pi)
        arcs = np.stack([chord * np.cos(half), chord * np.sin(half), 2.0 * half], axis=-1)
        earliest, expected = robot.contact_times(robot.when_effective(observation), arcs, ahead, self.comfort)
        walls = robot.clearances(observation.pose, 3.0, arcs[:, :4])
        expected[(walls < np.minimum(0.02, walls[2] - 0.02)).any(axis=1)] = 0.0
        free = (earliest >= self.horizon) & (expected > 0.0)
        # Of equally late contacts, that of the slowest motion is the best.
        return float(shares[free].max() if free.any() else min(shares[expected >= expected.max()], key=abs))


@dataclass(kw_only=True)
class Oracle:
    """Follows a shortest path in the ground-truth map: an upper bound for the performance of planners.

    The map lacks moving obstacles. Only planners that declare `oracle = true` get the map, and only in scenes of a
    family.

    Attributes:
        cruise: Maximum speed.
        look: Lookahead distance.
        clearance: Preferred gap between obstacles and the circle around the robot's outline.
        turn_rate: Maximum turn rate.
    """

    cruise: PositiveMetresPerSecond = 1.0
    look: PositiveMetres = 0.35
    clearance: PositiveMetres = 0.05
    turn_rate: RadiansPerSecond = 2.0

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Get the ground-truth map."""
        if "floor" not in task.privileged:
            raise InputError(Fault("an oracle needs a scene with a ground-truth map.", hint="Use a family."))
        self._robot, self._grid, self._path = Vehicle(task), task.privileged["floor"].grid(0.05), None

    def act(self, observation: Observation) -> list[float] | None:
        """Steer along the path, which is computed at the first call."""
        robot = self._robot
        if robot.arrived(observation):
            return None
        if np.isnan(observation.pose.x):
            return robot.stop()
        if self._path is None:
            self._path = self._shortest(observation)
        return steered(robot, observation, self._path, self.look, self.cruise, self.turn_rate)

    def _shortest(self, observation: Observation) -> list[tuple[float, float]]:
        """Shortest path for a disc, with the largest of five radii for which there is a path."""
        robot, start = self._robot, observation.pose[:2]
        widest, narrowest = robot.footprint.outer + self.clearance, robot.footprint.inner
        for radius in np.linspace(widest, narrowest, 5):
            path = self._grid.shortest(start, robot.goal[:2], float(radius))
            if path is not None:
                return list(path.points)
        return [start, robot.goal[:2]]


def steered(
    robot: Vehicle,
    observation: Observation,
    path: list[tuple[float, float]],
    look: float,
    cruise: float,
    turn_rate: float,
) -> list[float]:
    """Wheel linear speeds [m/s] for an arc to the point of a path that is the lookahead distance `look` [m] ahead."""
    pose = observation.pose
    ahead, aside = robot.lookahead_point(pose, path, look)
    distance = hypot(ahead, aside)
    if ahead <= 0.3 * distance:  # the point is beside or behind the robot
        return robot.move(0.0, float(np.copysign(min(turn_rate, 1.0), aside)))
    curvature = 2.0 * aside / max(distance, 1e-6) ** 2
    straight = np.column_stack([np.linspace(0.0, 1.2, 7), np.zeros(7), np.zeros(7)])
    gaps = robot.clearances(pose, 2.0, straight) if robot.has_map else np.full(7, inf)
    room = straight[:, 0][gaps < 0.05]
    speed = min(cruise, max(0.15, float(room[0]) if len(room) else inf), turn_rate / max(abs(curvature), 1e-6))
    return robot.move(speed, speed * curvature)
