"""Vehicle: a robot's outline, motion, goal and map, as Python planners use them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2, Twist2, along_arc, wrap_angle
from ..control.footprint import Footprint
from ..control.locomotion import Array
from ..knowledge import OCCUPIED, Window
from .python_planner import Observation, Task
from .route import Point

PROBABLE = 0.1
"""Probability below which a hypothesis of a mover's motion does not count."""

MARGIN = 0.3
"""Greatest standard deviation of a mover's position that counts [m]; what is far ahead must not close the way."""

CLOSING = 0.01
"""Approach to a mover that is within the margin already which counts as contact [m]; else the robot can leave it."""


class Vehicle:
    """View of a robot for a Python planner with one goal, independent of body and sensors: `Vehicle(task)` in `reset`.

    Args:
        task: Task of the planner.
        movers: Whether tracked movers count where they are predicted, instead of as obstacles of the latest scan.

    Attributes:
        locomotion: Locomotion of the robot.
        footprint: Outline of the robot.
        goal: Goal pose, world frame.
        tolerance: Goal tolerance [m].

    Raises:
        InputError: There is not exactly one goal, or the robot's length and width are unknown.
    """

    def __init__(self, task: Task, *, movers: bool = False) -> None:
        if len(task.goals) != 1:
            raise InputError(
                Fault(f"this planner needs exactly one goal, found {len(task.goals)}: {', '.join(task.goals)}.")
            )
        ((name, self.goal),) = task.goals.items()
        self.tolerance = task.tolerances[name]
        self.locomotion = task.locomotion
        self._world, self._predicts = task.knowledge.world, movers
        body = task.knowledge.graph.attributes(task.knowledge.agent)
        if not (body.get("length") and body.get("width")):
            raise InputError(
                Fault("this planner needs the robot's length and width; add a [body] table to its robot.toml.")
            )
        self.footprint = Footprint(body["length"], body["width"])
        self._distances: tuple[tuple[object, ...], Array] | None = None  # map section, distances from obstacles [m]

    @property
    def has_map(self) -> bool:
        """Whether the robot builds a map."""
        return self._world.occupancy is not None

    def arrived(self, observation: Observation) -> bool:
        """Whether the robot is at the goal."""
        return observation.pose.distance(self.goal) <= self.tolerance

    def to_goal(self, observation: Observation) -> tuple[float, float]:
        """Distance [m] of the goal, and its bearing relative to the robot's heading [rad], left positive."""
        pose = observation.pose
        return pose.distance(self.goal), wrap_angle(pose.bearing(self.goal))

    def motion(self, observation: Observation) -> tuple[float, float]:
        """Measured speed [m/s] and turn rate [rad/s] of the robot; 0 if unknown."""
        values = [observation.signals.get(name, np.array([math.nan])) for name in ("speed", "turn_rate")]
        speed, turn = (float(v[0]) for v in values)
        return (0.0 if math.isnan(speed) else speed), (0.0 if math.isnan(turn) else turn)

    def move(self, speed: float, turn: float) -> list[float]:
        """Values of the motion command with which the robot has a speed [m/s] and a turn rate [rad/s]."""
        values: list[float] = self.locomotion.command(Twist2(speed, turn)).tolist()
        return values

    def stop(self) -> list[float]:
        """Values of the motion command with which the robot stops: all 0."""
        return list(self.locomotion.rest)

    def obstacles(self, pose: Pose2, reach: float) -> Array:
        """Centres of occupied map cells in a square around the robot, body frame [m], shape (k, 2).

        Args:
            pose: Pose of the robot, world frame.
            reach: Half the side length of the square [m].

        Raises:
            InputError: The robot builds no map.
        """
        points = self._window(pose, reach).points()
        away = points - (pose.x, pose.y)
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        body: Array = away @ np.array([[c, -s], [s, c]])
        return body

    def clearances(self, pose: Pose2, reach: float, poses: Array) -> Array:
        """Gaps [m] between the robot's hull and occupied map cells, at several poses; +inf if no cell is near.

        The hull is approximated by discs that cover it, which is fast for thousands of poses. The gaps are therefore
        too small by a few centimetres, which is the safe side.

        Args:
            pose: Current pose, world frame.
            reach: Half the side length of the square section of the map around the robot that is used [m].
            poses: x [m], y [m], yaw [rad], body frame at `pose`, shape (..., 3).

        Returns:
            Gaps [m], shape (...).

        Raises:
            InputError: The robot builds no map.
        """
        window = self._window(pose, reach)
        smallest = np.full(poses.shape[:-1], np.inf)
        if not (window.states == OCCUPIED).any():
            return smallest
        away = self._distance_field(window)
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        count = math.ceil(self.footprint.length / self.footprint.width - 1e-9)
        part = self.footprint.length / (2 * count)
        radius = math.hypot(part, 0.5 * self.footprint.width)
        for k in range(count):
            ahead = (2 * k + 1) * part - 0.5 * self.footprint.length
            x, y = poses[..., 0] + ahead * np.cos(poses[..., 2]), poses[..., 1] + ahead * np.sin(poses[..., 2])
            column = ((pose.x + c * x - s * y - window.x) / window.cell).astype(np.intp)
            row = ((pose.y + s * x + c * y - window.y) / window.cell).astype(np.intp)
            inside = (row >= 0) & (row < away.shape[0]) & (column >= 0) & (column < away.shape[1])
            at = away[np.where(inside, row, 0), np.where(inside, column, 0)] - radius
            smallest = np.minimum(smallest, np.where(inside, at, np.inf))
        return smallest

    def contact_times(self, observation: Observation, poses: Array, ahead: Array, margin: float) -> tuple[Array, Array]:
        """Times until the robot comes too near to a predicted mover on each of k trajectories.

        The standard deviation of a mover's position adds to the margin. A mover that is already within the margin
        counts only if it comes nearer, so that the robot can leave it.

        Args:
            observation: Time and pose of the robot at the beginning of the trajectories.
            poses: x [m], y [m], yaw [rad], body frame at the beginning, shape (k, n, 3).
            ahead: Times from the beginning until these poses, ascending, shape (n,) [s].
            margin: Gap between hull and mover that is too small [m].

        Returns:
            Earliest time by all probable hypotheses of the movers' motions, and time that is expected with their
            probabilities, of the mover with the least, each of shape (k,); the last of `ahead` without a contact [s].
        """
        never, movers, pose = np.full(len(poses), ahead[-1]), self._world.movers, observation.pose
        if movers is None or not len(movers):
            return never, never
        prediction = movers.predict(observation.t + np.append(0.0, ahead)).above(PROBABLE)
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        there = poses @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + pose
        now = prediction.gaps(self.footprint, np.array([pose]), prediction.times[:1])
        first = np.full((len(poses), len(prediction)), ahead[-1])
        before = np.broadcast_to(now, first.shape)
        for k, step in enumerate(np.diff(ahead, prepend=0.0)):
            gaps = prediction.gaps(self.footprint, there[:, k], prediction.times[k + 1 : k + 2])
            least = np.minimum(margin + np.minimum(prediction.margin[:, k + 1], MARGIN), now - CLOSING)
            # Interpolated, so that of motions into what is near already the slower one is the better one.
            part = np.clip((gaps - least) / np.minimum(gaps - before, -1e-9), 0.0, 1.0)
            first = np.where(gaps < least, np.minimum(first, ahead[k] - step * part), first)
            before = gaps
        shares = (prediction.owner[:, None] == np.unique(prediction.owner)) * prediction.weight[:, None]
        expected = first @ (shares / shares.sum(axis=0))
        return first.min(axis=1), expected.min(axis=1)

    def when_effective(self, observation: Observation) -> Observation:
        """Observation at the time when a command of now begins to act, if the robot goes on as it moves until then."""
        late = self.locomotion.response.late
        pose = along_arc(observation.pose, Twist2(*self.motion(observation)), late)
        return replace(observation, t=observation.t + late, pose=pose)

    def lookahead_point(self, pose: Pose2, path: Sequence[Point], look: float) -> tuple[float, float]:
        """Point on a path at a distance ahead of the robot, or the end of the path; body frame [m].

        Args:
            pose: Current pose, world frame.
            path: Corners of the path, world frame [m].
            look: Look-ahead distance from the robot [m].
        """
        points = _resampled(path) - (pose.x, pose.y)
        away = np.hypot(*points.T)
        first = int(away.argmin())
        beyond = np.flatnonzero(away[first:] >= look)
        x, y = points[first + int(beyond[0])] if len(beyond) else points[-1]
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        return float(c * x + s * y), float(c * y - s * x)

    def _distance_field(self, window: Window) -> Array:
        """Distance of each cell of a window from the nearest occupied cell [m], shape (rows, columns)."""
        from scipy.ndimage import distance_transform_edt

        section = window.revision, window.x, window.y, window.states.shape
        if self._distances is None or self._distances[0] != section:
            self._distances = section, distance_transform_edt(window.states != OCCUPIED) * window.cell
        return self._distances[1]

    def _window(self, pose: Pose2, reach: float) -> Window:
        grid = self._world.occupancy
        if grid is None:
            raise InputError(Fault("this planner needs a map; add the analyser LocalMap to the robot."))
        low, high = (pose.x - reach, pose.y - reach), (pose.x + reach, pose.y + reach)
        return grid.window(low, high, moving=not self._predicts)


def _resampled(path: Sequence[Point], step: float = 0.05) -> Array:
    """Path with additional points, so that their distance is at most `step` [m]; shape (k, 2)."""
    corners = np.array(path, float)
    parts = [corners[:1]]
    for a, b in pairwise(corners):
        parts.append(np.linspace(a, b, max(2, math.ceil(float(np.hypot(*(b - a))) / step) + 1))[1:])
    return np.vstack(parts)
