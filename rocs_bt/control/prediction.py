"""Prediction: discs that move and grow over the next seconds, and their gaps to the outline of a robot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..base.geometry import Pose2, Twist2
from .footprint import Footprint, first_contact, poses_ahead
from .locomotion import Array

HYPOTHESES = ("goes on", "turns", "stops", "changes speed")
"""Hypotheses of how a mover goes on: with constant velocity or turn rate, by a stop where it is, or accelerating.

The last one leads a mover that brakes into a turn back, until it has its former speed again.
"""

PRIOR = (5 / 18, 3 / 18, 2 / 18, 8 / 18)
"""Probabilities of the hypotheses before any motion has been observed; without the last one in the same proportion."""

STEP = 0.05
"""Time step of the search for a collision [s]; nothing that walks passes through an outline within it."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """Predicted motion of the movers around a robot, in m rows; a mover has a row for each hypothesis of its motion.

    Attributes:
        times: Predicted times, ascending, shape (k,) [s].
        positions: Positions at these times, world frame, shape (m, k, 2) [m].
        radius: Radius of each mover, shape (m,) [m].
        margin: Standard deviation of the positions, shape (m, k) [m].
        weight: Probability of each row; those of one mover add up to 1, shape (m,).
        owner: Number of the mover of each row, as in `Movers.ids`, shape (m,).
        hypothesis: Index in `HYPOTHESES` of each row, shape (m,).
    """

    times: Array
    positions: Array
    radius: Array
    margin: Array
    weight: Array
    owner: npt.NDArray[np.int64]
    hypothesis: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.radius)

    def above(self, weight: float) -> Prediction:
        """The rows with at least a weight."""
        kept = self.weight >= weight
        return Prediction(
            times=self.times,
            positions=self.positions[kept],
            radius=self.radius[kept],
            margin=self.margin[kept],
            weight=self.weight[kept],
            owner=self.owner[kept],
            hypothesis=self.hypothesis[kept],
        )

    def at(self, times: Array) -> tuple[Array, Array]:
        """Positions, shape (n, m, 2) [m], and margins, shape (n, m) [m], interpolated; outside of `times` held.

        Args:
            times: Times, shape (n,) [s].
        """
        part = np.interp(times, self.times, np.arange(len(self.times)))
        low = np.minimum(part.astype(np.intp), max(len(self.times) - 2, 0))
        high, rest = np.minimum(low + 1, len(self.times) - 1), part - low
        positions = self.positions[:, low] + rest[:, None] * (self.positions[:, high] - self.positions[:, low])
        margin = self.margin[:, low] + rest * (self.margin[:, high] - self.margin[:, low])
        return positions.transpose(1, 0, 2), margin.T

    def gaps(self, hull: Footprint, poses: Array, times: Array) -> Array:
        """Signed distances between the outline of a robot and the discs of the movers, without margins.

        Args:
            hull: Outline of the robot.
            poses: Poses of the robot, world frame, shape (n, 3) [m, m, rad].
            times: Time of each pose, shape (n,), or one time for all poses, which is faster, shape (1,) [s].

        Returns:
            Gaps, shape (n, m) [m]; negative if they overlap.
        """
        positions, _ = self.at(times)
        c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        dx, dy = positions[..., 0] - poses[:, :1], positions[..., 1] - poses[:, 1:2]
        gaps = hull.gap(c * dx + s * dy, c * dy - s * dx)
        gaps -= self.radius
        return gaps

    def contact(self, hull: Footprint, pose: Pose2, twist: Twist2) -> tuple[float, float]:
        """First contact with a mover, and the smallest gap, of a robot that moves with a constant twist.

        A mover that already touches the robot counts only once it has come nearer, so that the robot can leave.

        Args:
            hull: Outline of the robot.
            pose: Pose of the robot at the first predicted time, world frame.
            twist: Velocity of the robot, body frame.

        Returns:
            Time from the first predicted time to the contact [s], +inf without one; smallest gap [m], +inf without
            movers.
        """
        if not len(self):
            return math.inf, math.inf
        until = float(self.times[-1] - self.times[0])
        ahead = np.linspace(0.0, until, max(math.ceil(until / STEP - 1e-9), 1) + 1)
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        poses = poses_ahead(twist, ahead) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + pose
        gaps = self.gaps(hull, poses, self.times[0] + ahead)
        return first_contact(ahead, gaps, gaps[0]), float(gaps.min())


def accelerated(velocity: Array, acceleration: Array, top: Array, ahead: Array) -> Array:
    """Displacements of n movers with constant accelerations up to a top speed, after times ahead, (n, k, 2) [m].

    Args:
        velocity: Velocities, shape (n, 2) [m/s].
        acceleration: Accelerations, shape (n, 2) [m/s2].
        top: Speed in the direction of the acceleration at which it ends, shape (n,) [m/s].
        ahead: Times, shape (k,) [s].
    """
    size = np.maximum(np.hypot(*acceleration.T), 1e-6)
    along = (velocity * acceleration).sum(axis=1) / size
    until = np.maximum(top - along, 0.0)[:, None] / size[:, None]
    ramp = np.minimum(ahead, until)
    gained = ramp * (ahead - 0.5 * ramp)
    moved: Array = velocity[:, None] * ahead[:, None] + acceleration[:, None] * gained[..., None]
    return moved


def displaced(velocity: Array, turn_rate: Array, ahead: Array) -> Array:
    """Displacements of movers at constant speeds and turn rates, shape (n, k, 2) [m].

    Args:
        velocity: Present velocities, world frame, shape (n, 2) [m/s].
        turn_rate: Turn rates, left positive, shape (n,) [rad/s].
        ahead: Times ahead, shape (k,) [s].
    """
    half = 0.5 * turn_rate[:, None] * ahead
    chord, c, s = ahead * np.sinc(half / np.pi), np.cos(half), np.sin(half)
    vx, vy = velocity[:, :1], velocity[:, 1:]
    return np.stack([chord * (c * vx - s * vy), chord * (s * vx + c * vy)], axis=-1)
