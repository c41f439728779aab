"""Planners that predict many candidate motions over a short horizon and drive the first part of the best one."""

from dataclasses import dataclass, field
from math import inf

import numpy as np

from rocs_bt import MetresPerSecond, PositiveMetres, PositiveMetresPerSecond, PositiveSeconds, RadiansPerSecond
from rocs_bt.plan import NoRoute, Observation, RoutePlanner, Task, Vehicle


@dataclass(kw_only=True)
class DynamicWindow:
    """Dynamic window approach: drives the best arc among those that the wheels can reach within a period.

    Source: Fox, Burgard and Thrun, The dynamic window approach to collision avoidance (IEEE RAM 4, 1997). The score of
    an arc is the weighted sum of heading, clearance and speed, each normalised, with the weights of the paper. The arcs
    lead toward a point ahead on the path of a route planner, as is common practice today. Without a path, the method
    would stop before each wall on the straight line to the goal.

    Among movers, the score is a sum of times, because a normalised clearance counts walls as much as people: the times
    until contacts with movers and with walls, with their weights, less the time still needed to the lookahead point,
    and the speed as a part of `cruise` with its weight [s].

    Attributes:
        cruise: Maximum speed.
        turn_rate: Maximum turn rate.
        period: Time within which the speeds of the candidate arcs can be reached.
        horizon: Time for which each arc is predicted.
        heading: Weight of the heading at the end of the arc.
        clearance: Weight of the time until contact along the arc.
        speed: Weight of the speed.
        margin: Minimum gap between the hull and obstacles along an arc.
        planner: Route planner: name of a file in planners/routes.
        look: Lookahead distance on the path.
        movers: Whether arcs are compared with the predicted movers in space and time.
        contact: Weight of the expected time until contact with a mover.
        comfort: Gap to a mover that counts as contact.
        back: Maximum speed in reverse.
    """

    cruise: PositiveMetresPerSecond = 1.0
    turn_rate: RadiansPerSecond = 2.0
    period: PositiveSeconds = 0.25
    horizon: PositiveSeconds = 1.5
    heading: float = 0.8
    clearance: float = 0.1
    speed: float = 0.1
    margin: PositiveMetres = 0.04
    planner: str = "grid_astar"
    look: PositiveMetres = 1.0
    movers: bool = False
    contact: float = 2.0
    comfort: PositiveMetres = 0.1
    back: MetresPerSecond = 0.0

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Read the robot's dimensions and limits, and create the route planner."""
        self._robot, self._routes = Vehicle(task, movers=self.movers), task.route(self.planner)
        self._routes.moving = not self.movers

    def act(self, observation: Observation) -> list[float] | None:
        """Select the best arc; without a free one, turn on the spot, or among movers keep the largest gap."""
        robot = self._robot
        if robot.arrived(observation):
            return None
        if np.isnan(observation.pose.x):
            return robot.stop()
        if self.movers:
            observation = robot.when_effective(observation)
        aim = aimed(robot, self._routes, observation, self.look, self.margin)
        v, w = self._window(*robot.motion(observation))
        steps = np.linspace(0.0, self.horizon, 9)[1:]
        poses = arcs(v, w, steps)
        gaps = robot.clearances(observation.pose, self.cruise * self.horizon + 1.0, poses)
        braking = np.abs(v) / (0.7 * robot.locomotion.acceleration_limit) + self.period
        nearest = np.where(steps <= braking[:, None] + 0.2, gaps, inf).min(axis=1)
        free = nearest > self.margin
        if self.movers and not free.any():  # such as after a push towards a wall
            free = nearest >= nearest.max() - 0.01
        if not free.any():
            return robot.move(0.0, 0.8 if aim[1] >= 0.0 else -0.8)
        walls = _until_contact(gaps, steps, self.margin)
        if self.movers:
            earliest, expected = robot.contact_times(observation, poses, steps, self.comfort)
            safe = free & (earliest > braking)
            if safe.any():
                free, left = safe, np.hypot(aim[0] - poses[:, -1, 0], aim[1] - poses[:, -1, 1]) / self.cruise
                score = self.contact * expected + self.clearance * walls + self.speed * v / self.cruise - left
            else:  # it cannot stop before a contact: a late one, and no driving into it
                score = expected - 0.2 * np.abs(v) / self.cruise
        else:
            score = (
                self.heading * _normal(facing(aim, poses[:, 3]), free)
                + self.clearance * _normal(walls, free)
                + self.speed * _normal(v, free)
            )
        best = int(np.argmax(np.where(free, score, -inf)))
        return robot.move(float(v[best]), float(w[best]))

    def _window(self, speed: float, turn: float) -> tuple[np.ndarray, np.ndarray]:
        """Speeds [m/s] and turn rates [rad/s] reachable within the period from the present ones, each of shape (k,)."""
        locomotion = self._robot.locomotion
        room = locomotion.acceleration_limit * self.period
        v = np.linspace(max(-self.back, speed - room), min(self.cruise, max(speed, 0.0) + room), 9)
        reach = locomotion.turn_acceleration_limit * self.period
        w = np.linspace(max(-self.turn_rate, turn - reach), min(self.turn_rate, turn + reach), 15)
        grid = np.meshgrid(v, np.append(w, 0.0), indexing="ij")
        return grid[0].ravel(), grid[1].ravel()


@dataclass(kw_only=True)
class Mppi:
    """Model predictive path integral control: drives the cost-weighted mean of randomly perturbed trajectories.

    Source: Williams, Aldrich and Theodorou, Model predictive path integral control (J. Guidance, Control, and Dynamics
    40, 2017). The cost of a trajectory is the time still needed from its end to the lookahead point, plus a high
    penalty for small gaps to obstacles.

    Attributes:
        cruise: Maximum speed.
        turn_rate: Maximum turn rate.
        horizon: Planning horizon.
        step: Time step of a trajectory.
        courses: Number of sampled trajectories.
        temperature: Temperature of the weights; higher values give worse trajectories more weight.
        gap: Gap to obstacles below which the penalty begins.
        planner: Route planner: name of a file in planners/routes.
        look: Lookahead distance on the path.
        movers: Whether trajectories are compared with the predicted movers in space and time.
        contact: Cost of an immediate contact with a mover [s]; a later one costs less, one at full speed twice as much.
        comfort: Gap to a mover that counts as contact.
        back: Maximum speed in reverse.
    """

    cruise: PositiveMetresPerSecond = 1.0
    turn_rate: RadiansPerSecond = 2.0
    horizon: PositiveSeconds = 2.0
    step: PositiveSeconds = 0.1
    courses: int = 200
    temperature: float = 0.3
    gap: PositiveMetres = 0.25
    planner: str = "grid_astar"
    look: PositiveMetres = 1.5
    movers: bool = False
    contact: float = 10.0
    comfort: PositiveMetres = 0.1
    back: MetresPerSecond = 0.0
    _plan: np.ndarray = field(default_factory=lambda: np.empty((0, 2)), init=False)

    def reset(self, task: Task, rng: np.random.Generator) -> None:
        """Begin with a stationary trajectory."""
        self._robot, self._rng = Vehicle(task, movers=self.movers), rng
        self._routes = task.route(self.planner)
        self._routes.moving = not self.movers
        self._plan, self._begins = np.zeros((round(self.horizon / self.step), 2)), -inf

    def act(self, observation: Observation) -> list[float] | None:
        """Shift the last trajectory by a step, perturb it, and drive the first step of the weighted mean."""
        robot = self._robot
        if robot.arrived(observation):
            return None
        if np.isnan(observation.pose.x):
            return robot.stop()
        if self.movers:
            observation = robot.when_effective(observation)
        if not self.movers or observation.t > self._begins + 0.99 * self.step:
            self._plan, self._begins = np.vstack([self._plan[1:], self._plan[-1:]]), observation.t
        noise = self._rng.normal(0.0, (0.3 * self.cruise, 0.5 * self.turn_rate), (self.courses, *self._plan.shape))
        noise = np.cumsum(noise, axis=1) / np.sqrt(np.arange(1, len(self._plan) + 1))[:, None]
        tried = np.clip(self._plan + noise, (-self.back, -self.turn_rate), (self.cruise, self.turn_rate))
        cost = self._costs(observation, tried)
        weights = np.exp(-(cost - cost.min()) / self.temperature)
        self._plan = np.tensordot(weights / weights.sum(), tried, axes=1)
        speed, turn = self._plan[0].tolist()
        return robot.move(speed, turn)

    def _costs(self, observation: Observation, tried: np.ndarray) -> np.ndarray:
        """Cost of each trajectory [s], shape (k,)."""
        robot, count = self._robot, tried.shape[1]
        yaw = np.cumsum(tried[:, :, 1] * self.step, axis=1)
        x = np.cumsum(tried[:, :, 0] * self.step * np.cos(yaw), axis=1)
        y = np.cumsum(tried[:, :, 0] * self.step * np.sin(yaw), axis=1)
        every = slice(1, None, 2)  # every second pose suffices: the robot is longer than several steps
        poses = np.stack([x, y, yaw], axis=-1)[:, every]
        gaps = robot.clearances(observation.pose, self.cruise * self.horizon + 0.5, poses)
        gaps = np.minimum(gaps, self.gap)
        ahead, aside = aimed(robot, self._routes, observation, self.look, 0.03)
        left = np.hypot(ahead - x[:, -1], aside - y[:, -1])
        near = ((self.gap - gaps) / self.gap).sum(axis=1) * 2.0 * self.horizon / count
        hit = 20.0 * (gaps <= 0.03).any(axis=1)
        cost: np.ndarray = left / self.cruise + near + hit
        if self.movers:
            times = self.step * np.arange(1, count + 1)[every]
            _, until = robot.contact_times(observation, poses, times, self.comfort)
            early, driven = 1.0 - until / self.horizon, np.abs(tried[:, :, 0]).mean(axis=1) / self.cruise
            cost += self.contact * early * (1.0 + early * driven)  # driving into a person is worse than being met
        return cost


def aimed(
    robot: Vehicle, routes: RoutePlanner, observation: Observation, look: float, clearance: float
) -> tuple[float, float]:
    """Lookahead point in the body frame [m]: ahead on the path, or toward the goal if there is no path."""
    pose = observation.pose
    try:
        path = routes.route(pose, robot.goal, clearance)
    except NoRoute:
        path = [pose[:2], robot.goal[:2]]
    return robot.lookahead_point(pose, path, look)


def facing(aim: tuple[float, float], ends: np.ndarray) -> np.ndarray:
    """How well the robot faces a point at the end of each arc, from 0 (faces away) to 1, shape (k,).

    Args:
        aim: Point in the body frame [m].
        ends: Pose at the end of each arc, body frame, shape (k, 3).
    """
    to = np.arctan2(aim[1] - ends[:, 1], aim[0] - ends[:, 0]) - ends[:, 2]
    return 1.0 - np.abs(np.mod(to + np.pi, 2.0 * np.pi) - np.pi) / np.pi


def arcs(v: np.ndarray, w: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Poses in the body frame after times [s] at constant speeds [m/s] and turn rates [rad/s], shape (k, n, 3)."""
    yaw = w[:, None] * times
    straight = np.abs(w) < 1e-6
    safe = np.where(straight, 1.0, w)[:, None]
    x = np.where(straight[:, None], v[:, None] * times, v[:, None] / safe * np.sin(yaw))
    y = np.where(straight[:, None], 0.0, v[:, None] / safe * (1.0 - np.cos(yaw)))
    return np.stack([x, y, yaw], axis=-1)


def _until_contact(gaps: np.ndarray, times: np.ndarray, margin: float) -> np.ndarray:
    """Time until each arc comes too near to an obstacle [s], shape (k,); the whole horizon if it does not."""
    near = gaps <= margin
    return np.where(near.any(axis=1), times[near.argmax(axis=1)], times[-1])


def _normal(values: np.ndarray, of: np.ndarray) -> np.ndarray:
    """Values scaled so that those selected by the mask `of` range from 0 to 1, shape (k,)."""
    low, high = values[of].min(), values[of].max()
    return (values - low) / (high - low) if high > low else np.zeros_like(values)
