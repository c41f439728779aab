"""Vehicle: what a planner in Python needs of its robot: its outline, its wheels, and what stands around it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..control.drive import Array
from ..control.footprint import Footprint
from ..errors import Fault, InputError
from ..geometry import Pose2, Twist2, wrap_angle
from ..knowledge import OCCUPIED, Window
from .python_planner import Observation, Task
from .route import Point


class Vehicle:
    """A robot as its planners see it, whatever its wheels and sensors are.

    Args:
        task: What the planner was told.

    Attributes:
        drive: The robot's drive.
        footprint: Its outline.
        goal: Where it is to go, world frame.
        tolerance: How near counts as there [m].

    Raises:
        InputError: There is not exactly one goal, or the robot's length and width are not known.
    """

    def __init__(self, task: Task) -> None:
        if len(task.goals) != 1:
            raise InputError(
                Fault(f"this planner drives to one goal, found {len(task.goals)}: {', '.join(task.goals)}.")
            )
        ((name, self.goal),) = task.goals.items()
        self.tolerance = task.tolerances[name]
        self.drive = task.drive
        self._world = task.knowledge.world
        body = task.knowledge.graph.attributes(task.knowledge.agent)
        if not (body.get("length") and body.get("width")):
            raise InputError(Fault("this planner needs the robot's length and width; write a [body] table."))
        self.footprint = Footprint(body["length"], body["width"])

    @property
    def maps(self) -> bool:
        """Whether it draws a map of its own."""
        return self._world.occupancy is not None

    def arrived(self, observation: Observation) -> bool:
        """Whether it is at the goal."""
        return observation.pose.distance(self.goal) <= self.tolerance

    def to_goal(self, observation: Observation) -> tuple[float, float]:
        """The goal's distance [m] and bearing [rad], left positive."""
        pose = observation.pose
        return pose.distance(self.goal), wrap_angle(pose.bearing(self.goal))

    def motion(self, observation: Observation) -> tuple[float, float]:
        """How fast it drives [m/s] and turns [rad/s]; 0 where that is not known."""
        values = [observation.signals.get(name, np.array([math.nan])) for name in ("speed", "turn_rate")]
        speed, turn = (float(v[0]) for v in values)
        return (0.0 if math.isnan(speed) else speed), (0.0 if math.isnan(turn) else turn)

    def wheels(self, speed: float, turn: float) -> list[float]:
        """Wheel linear speeds [m/s] that drive at `speed` [m/s] and turn at `turn` [rad/s]."""
        speeds: list[float] = self.drive.wheel_speeds(Twist2(speed, turn)).tolist()
        return speeds

    def stand(self) -> list[float]:
        """Rim speeds of one that stands."""
        return [0.0] * len(self.drive.wheels)

    def things(self, pose: Pose2, reach: float) -> Array:
        """(k, 2) What its own map shows within a reach [m], in its body frame [m].

        Raises:
            InputError: It draws no map.
        """
        points = self._window(pose, reach).points()
        away = points - (pose.x, pose.y)
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        body: Array = away @ np.array([[c, -s], [s, c]])
        return body

    def gaps(self, pose: Pose2, reach: float, poses: Array) -> Array:
        """(...,) The room beside the hull in poses (..., 3) of its present body frame [m]; +inf where nothing is near.

        The hull counts as discs that cover it, and the map as its cells, so that this is quick for thousands of poses,
        and a few centimetres on the safe side.

        Args:
            pose: Where it is, world frame.
            reach: How far around it the map is looked at [m].
            poses: x [m], y [m], yaw [rad].

        Raises:
            InputError: It draws no map.
        """
        window = self._window(pose, reach)
        occupied = window.states == OCCUPIED
        if not occupied.any():
            return np.full(poses.shape[:-1], np.inf)
        from scipy.ndimage import distance_transform_edt

        away = distance_transform_edt(~occupied) * window.cell
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        count = math.ceil(self.footprint.length / self.footprint.width - 1e-9)
        part = self.footprint.length / (2 * count)
        radius = math.hypot(part, 0.5 * self.footprint.width)
        least = np.full(poses.shape[:-1], np.inf)
        for k in range(count):
            ahead = (2 * k + 1) * part - 0.5 * self.footprint.length
            x, y = poses[..., 0] + ahead * np.cos(poses[..., 2]), poses[..., 1] + ahead * np.sin(poses[..., 2])
            column = ((pose.x + c * x - s * y - window.x) / window.cell).astype(np.intp)
            row = ((pose.y + s * x + c * y - window.y) / window.cell).astype(np.intp)
            inside = (row >= 0) & (row < away.shape[0]) & (column >= 0) & (column < away.shape[1])
            at = away[np.where(inside, row, 0), np.where(inside, column, 0)] - radius
            least = np.minimum(least, np.where(inside, at, np.inf))
        return least

    def ahead(self, pose: Pose2, way: Sequence[Point], look: float) -> tuple[float, float]:
        """The point of a way that is a distance ahead [m], or its end, in the body frame [m].

        Args:
            pose: Where it is, world frame.
            way: Corners in the world frame [m].
            look: How far from the robot.
        """
        points = _dense(way) - (pose.x, pose.y)
        away = np.hypot(*points.T)
        first = int(away.argmin())
        beyond = np.flatnonzero(away[first:] >= look)
        x, y = points[first + int(beyond[0])] if len(beyond) else points[-1]
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        return float(c * x + s * y), float(c * y - s * x)

    def _window(self, pose: Pose2, reach: float) -> Window:
        grid = self._world.occupancy
        if grid is None:
            raise InputError(Fault("this planner needs a map; give the robot the analyser LocalMap."))
        return grid.window((pose.x - reach, pose.y - reach), (pose.x + reach, pose.y + reach))


def _dense(way: Sequence[Point], step: float = 0.05) -> Array:
    """(k, 2) A way with a point at least every so often [m]."""
    corners = np.array(way, float)
    told = [corners[:1]]
    for a, b in pairwise(corners):
        told.append(np.linspace(a, b, max(2, math.ceil(float(np.hypot(*(b - a))) / step) + 1))[1:])
    return np.vstack(told)
