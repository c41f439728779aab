"""Extended Kalman filter over pose and gyro bias.

The prediction uses wheels and gyro: each short motion is an arc with body-frame noise that grows with the distance. The
corrections are position and heading fixes in the world frame. With a gyro, its bias is estimated from the fixes.
Sources: Thrun, Burgard and Fox, Probabilistic Robotics (2005), 5.4 (odometry as a control) and 7.4 (the filter);
Borenstein and Feng, Gyrodometry, ICRA 1996 (the turn from the gyro, where there is one).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base.geometry import Pose2, wrap_angle
from .locomotion import Array


@dataclass(frozen=True)
class PoseNoise:
    """Noise parameters of the filter, as standard deviations; those that grow are given for one unit of motion or time.

    Attributes:
        travel: Error of the driven distance, after a metre [m].
        slip: Lateral slip, after a metre [m].
        turn: Error of the wheels' heading, after a turn of a radian and after a metre [rad].
        gyro: Error of the gyro's turn rate [rad/s].
        gyro_bias: Initial bias of the gyro [rad/s].
        drift: Drift of the position, after a second, independent of the motion [m].
        fix_position: Error of each coordinate of a position fix [m].
        fix_heading: Error of a heading fix [rad].
    """

    travel: float = 0.02
    slip: float = 0.01
    turn: float = 0.02
    gyro: float = 0.002
    gyro_bias: float = 0.005
    drift: float = 0.002
    fix_position: float = 0.05
    fix_heading: float = math.radians(5.0)


class PoseFilter:
    """Extended Kalman filter of one robot's pose.

    Args:
        pose: First fix, world frame.
        noise: Noise parameters; None for the default ones.

    Attributes:
        state: x [m], y [m], yaw [rad], in (-pi, pi], and gyro bias [rad/s], shape (4,).
        covariance: Covariance of the state, shape (4, 4).
    """

    def __init__(self, pose: Pose2, noise: PoseNoise | None = None) -> None:
        self.noise = noise = noise or PoseNoise()
        self.state: Array = np.array([pose.x, pose.y, wrap_angle(pose.yaw), 0.0])
        self.covariance: Array = np.diag(
            np.square([noise.fix_position, noise.fix_position, noise.fix_heading, noise.gyro_bias])
        )

    def predict(self, forward: float, left: float, turn: float, dt: float, turn_rate: float = math.nan) -> None:
        """Propagate the state by one short motion.

        Args:
            forward: Distance of the body's centre along the arc [m].
            left: Lateral distance, of drives that can move sideways [m].
            turn: Turn measured by the wheels [rad].
            dt: Duration of the motion [s].
            turn_rate: Mean turn rate measured by the gyro [rad/s]; NaN without a gyro.
        """
        noise, way = self.noise, math.hypot(forward, left)
        by_gyro = math.isfinite(turn_rate)
        turn_variance = (noise.gyro * dt) ** 2 if by_gyro else noise.turn**2 * (abs(turn) + way)
        if by_gyro:
            turn = (turn_rate - float(self.state[3])) * dt
        yaw, half = float(self.state[2]), 0.5 * turn
        c, s = math.cos(yaw + half), math.sin(yaw + half)
        # Ratio of chord to arc, and its derivative by half the turn.
        chord = math.sin(half) / half if abs(half) > 1e-6 else 1.0
        bend = (math.cos(half) - chord) / half if abs(half) > 1e-6 else -half / 3.0
        ahead, aside = c * forward - s * left, s * forward + c * left  # world frame, as long as the arc
        dx, dy = chord * ahead, chord * aside
        self.state[:3] += dx, dy, turn
        self.state[2] = wrap_angle(float(self.state[2]))
        by_turn = np.array([0.5 * (bend * ahead - dy), 0.5 * (bend * aside + dx), 1.0, 0.0])
        slope = np.eye(4)
        slope[0, 2], slope[1, 2] = -dy, dx
        if by_gyro:
            slope[:, 3] -= dt * by_turn
        self.covariance = slope @ self.covariance @ slope.T + turn_variance * np.outer(by_turn, by_turn)
        a, b, floor = noise.travel**2 * way, noise.slip**2 * way, noise.drift**2 * dt
        self.covariance[0, 0] += a * c * c + b * s * s + floor
        self.covariance[1, 1] += a * s * s + b * c * c + floor
        self.covariance[0, 1] += (a - b) * c * s
        self.covariance[1, 0] += (a - b) * c * s

    def widen(self, distance: float, angle: float) -> None:
        """Increase the uncertainty by an independent error with these standard deviations.

        Args:
            distance: Standard deviation of each coordinate of the position [m].
            angle: Standard deviation of the heading [rad].
        """
        self.covariance[[0, 1, 2], [0, 1, 2]] += distance**2, distance**2, angle**2

    def fix_position(self, x: float, y: float) -> None:
        """Correct the state by a position fix, world frame [m]."""
        self._correct((0, 1), np.array([x, y]) - self.state[:2], self.noise.fix_position)

    def fix_heading(self, yaw: float) -> None:
        """Correct the state by a heading fix, world frame [rad]."""
        self._correct((2,), np.array([wrap_angle(yaw - float(self.state[2]))]), self.noise.fix_heading)

    @property
    def pose(self) -> Pose2:
        """Estimated pose, world frame."""
        return Pose2(*self.state[:3].tolist())

    @property
    def spread(self) -> float:
        """Standard deviation of the position along the major axis of its error ellipse [m]."""
        return major_deviation(self.covariance)

    def _correct(self, which: Sequence[int], error: Array, deviation: float) -> None:
        """Correct the variables `which` by measured minus estimated values with standard deviations."""
        chosen = np.eye(4)[list(which)]
        across = self.covariance @ chosen.T
        spread = deviation**2 * np.eye(len(which))
        gain = across @ np.linalg.inv(chosen @ across + spread)
        self.state = self.state + gain @ error
        self.state[2] = wrap_angle(float(self.state[2]))
        rest = np.eye(4) - gain @ chosen
        # Joseph form: stays symmetric and positive under rounding.
        self.covariance = rest @ self.covariance @ rest.T + gain @ spread @ gain.T


def major_deviation(covariance: Array) -> float:
    """Standard deviation along the major axis of the error ellipse of a covariance's first two variables."""
    (a, b), (_, d) = covariance[:2, :2].tolist()
    return math.sqrt(max(0.0, 0.5 * (a + d) + math.hypot(0.5 * (a - d), b)))
