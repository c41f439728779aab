"""Where a robot is, from its own motion and from fixes: a small extended Kalman filter.

The motion is what wheels and gyro tell of each short stretch, taken as an arc; it enters as a control with noise in
the body frame that grows with what was driven. Fixes are positions and headings in the world frame. With a gyro its
bias is estimated too: it shows in what the fixes correct.
Sources: Thrun, Burgard and Fox, Probabilistic Robotics (2005), 5.4 (odometry as a control) and 7.4 (the filter);
Borenstein and Feng, Gyrodometry, ICRA 1996 (the turn from the gyro, where there is one).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..geometry import Pose2, wrap_angle
from .drive import Array


@dataclass(frozen=True)
class PoseNoise:
    """What a filter takes for granted of the sensors; standard deviations, of what grows after one unit.

    Attributes:
        along: Of the way driven, after a metre [m].
        aside: Of the slip to the side, after a metre [m].
        turning: Of the heading by the wheels, after a turn of a radian, and after a metre of way [rad].
        gyro: Of a turn rate that the gyro tells [rad/s].
        bias: Of the gyro's bias at the start [rad/s].
        drift: Of the position, after a second, whatever the wheels do [m].
        position: Of each coordinate of a fix [m].
        heading: Of the heading of a fix [rad].
    """

    along: float = 0.02
    aside: float = 0.01
    turning: float = 0.02
    gyro: float = 0.002
    bias: float = 0.005
    drift: float = 0.002
    position: float = 0.05
    heading: float = math.radians(5.0)


class PoseFilter:
    """Follows one robot.

    Args:
        pose: A first fix, world frame.
        noise: What to take for granted.

    Attributes:
        state: (4,) x [m], y [m], yaw [rad], in (-pi, pi], and the gyro's bias [rad/s].
        covariance: (4, 4) Of the state.
    """

    def __init__(self, pose: Pose2, noise: PoseNoise | None = None) -> None:
        self.noise = noise = noise or PoseNoise()
        self.state: Array = np.array([pose.x, pose.y, wrap_angle(pose.yaw), 0.0])
        self.covariance: Array = np.diag(np.square([noise.position, noise.position, noise.heading, noise.bias]))

    def predict(self, forward: float, left: float, turn: float, dt: float, turn_rate: float = math.nan) -> None:
        """Move on by what was driven in one stretch.

        Args:
            forward: The way of the body's centre along the arc [m].
            left: Its way to the side [m], of drives that can go there.
            turn: What the wheels tell of the turn [rad].
            dt: How long it took [s].
            turn_rate: What the gyro tells, the mean of the stretch [rad/s]; NaN without one.
        """
        noise, way = self.noise, math.hypot(forward, left)
        by_gyro = math.isfinite(turn_rate)
        turn_variance = (noise.gyro * dt) ** 2 if by_gyro else noise.turning**2 * (abs(turn) + way)
        if by_gyro:
            turn = (turn_rate - float(self.state[3])) * dt
        yaw, half = float(self.state[2]), 0.5 * turn
        c, s = math.cos(yaw + half), math.sin(yaw + half)
        # The chord's share of the arc, and how that changes with half the turn.
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
        a, b, floor = noise.along**2 * way, noise.aside**2 * way, noise.drift**2 * dt
        self.covariance[0, 0] += a * c * c + b * s * s + floor
        self.covariance[1, 1] += a * s * s + b * c * c + floor
        self.covariance[0, 1] += (a - b) * c * s
        self.covariance[1, 0] += (a - b) * c * s

    def widen(self, distance: float, angle: float) -> None:
        """Trust the position by a distance [m] less, and the heading by an angle [rad]."""
        self.covariance[[0, 1, 2], [0, 1, 2]] += distance**2, distance**2, angle**2

    def fix_position(self, x: float, y: float) -> None:
        """Take a position, world frame [m]."""
        self._correct((0, 1), np.array([x, y]) - self.state[:2], self.noise.position)

    def fix_heading(self, yaw: float) -> None:
        """Take a heading, world frame [rad]."""
        self._correct((2,), np.array([wrap_angle(yaw - float(self.state[2]))]), self.noise.heading)

    @property
    def pose(self) -> Pose2:
        """Where the robot most likely is, world frame."""
        return Pose2(*self.state[:3].tolist())

    @property
    def spread(self) -> float:
        """Standard deviation of the position, along the axis on which it is greatest [m]."""
        (a, b), (_, d) = self.covariance[:2, :2].tolist()
        return math.sqrt(max(0.0, 0.5 * (a + d) + math.hypot(0.5 * (a - d), b)))

    def _correct(self, which: Sequence[int], error: Array, deviation: float) -> None:
        """Take a measurement of some of the state, whose values are all equally sure."""
        chosen = np.eye(4)[list(which)]
        across = self.covariance @ chosen.T
        spread = deviation**2 * np.eye(len(which))
        gain = across @ np.linalg.inv(chosen @ across + spread)
        self.state = self.state + gain @ error
        self.state[2] = wrap_angle(float(self.state[2]))
        rest = np.eye(4) - gain @ chosen
        # Joseph's form: symmetric and positive whatever rounding does.
        self.covariance = rest @ self.covariance @ rest.T + gain @ spread @ gain.T
