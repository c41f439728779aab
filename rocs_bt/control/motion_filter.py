"""Where something is and how it moves, from ranges and bearings: a small extended Kalman filter.

The motion is the coordinated turn: constant speed and turn rate, disturbed by white accelerations of both. Its state
has velocities along the world's axes, not speed and heading, so that nothing is singular while it stands.
Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), 11.7.

Matrices are multiplied by `dot`: for ones as small as these it takes half the time of `@`, to the same bits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from ..geometry import Pose2, wrap_angle
from .drive import Array


@dataclass(frozen=True)
class MotionNoise:
    """What a filter takes for granted of who moves, and of who looks.

    Attributes:
        range: Standard deviation of a range [m].
        bearing: Standard deviation of a bearing [rad].
        acceleration: Density of the accelerations that disturb its velocity [m2/s3].
        turning: Density of those that disturb its turn rate [rad2/s3].
        memory: Time constant with which a turn that nobody sees goes on dies away [s].
    """

    range: float = 0.05
    bearing: float = math.radians(2.0)
    acceleration: float = 0.05
    turning: float = 0.5
    memory: float = 2.0


_EYE = np.eye(5)
START_SPEED = 0.5  # [m/s] standard deviation of either velocity of who has just come into view
START_TURN = 0.5  # [rad/s]


class MotionFilter:
    """Follows one thing that moves.

    Args:
        t: When it was seen first [s].
        observer: Who saw it, world frame.
        distance: How far from there [m].
        bearing: In which direction, left of the observer's heading positive [rad].
        noise: What to take for granted.

    Attributes:
        t: The time that the state is about [s].
        state: (5,) x [m], y [m], their velocities [m/s], turn rate [rad/s]; world frame.
        covariance: (5, 5) Of the state.
    """

    def __init__(
        self, t: float, observer: Pose2, distance: float, bearing: float, noise: MotionNoise | None = None
    ) -> None:
        self.t = t
        self.noise = noise or MotionNoise()
        self._spread = np.diag([self.noise.range**2, self.noise.bearing**2])
        self._disturbance = lru_cache(maxsize=16)(partial(_disturbance, self.noise))  # steps are nearly always alike
        c, s = math.cos(observer.yaw + bearing), math.sin(observer.yaw + bearing)
        x, y = observer.x + distance * c, observer.y + distance * s
        self.state: Array = np.array([x, y, 0.0, 0.0, 0.0])
        lever = np.array([[c, -distance * s], [s, distance * c]])
        self.covariance: Array = np.diag([0.0, 0.0, START_SPEED**2, START_SPEED**2, START_TURN**2])
        self.covariance[:2, :2] = lever @ self._spread @ lever.T

    def predict(self, t: float) -> None:
        """Move on to time t [s]; an earlier one changes nothing."""
        dt = t - self.t
        if dt <= 0.0:
            return
        self.t = t
        self.state, slope = _turn_on(self.state, dt, math.exp(-dt / self.noise.memory))
        self.covariance = slope.dot(self.covariance).dot(slope.T) + self._disturbance(dt)

    def update(self, t: float, observer: Pose2, distance: float, bearing: float) -> None:
        """Take a sighting at time t [s]: range [m] and bearing [rad] from an observer in the world frame."""
        self.predict(t)
        x, y, *_ = self.state.tolist()
        dx, dy = x - observer.x, y - observer.y
        expected = math.hypot(dx, dy)
        if expected < 1e-6:
            return  # no direction: nothing can be learned of one
        slope = np.array(
            [[dx / expected, dy / expected, 0.0, 0.0, 0.0], [-dy / expected**2, dx / expected**2, 0.0, 0.0, 0.0]]
        )
        error = np.array([distance - expected, wrap_angle(bearing - wrap_angle(math.atan2(dy, dx) - observer.yaw))])
        across = self.covariance.dot(slope.T)
        gain = across.dot(_inverse(slope.dot(across) + self._spread))
        self.state = self.state + gain.dot(error)
        rest = _EYE - gain.dot(slope)
        # Joseph's form: symmetric and positive whatever rounding does.
        self.covariance = rest.dot(self.covariance).dot(rest.T) + gain.dot(self._spread).dot(gain.T)

    @property
    def spread(self) -> float:
        """Standard deviation of the position, along the axis on which it is greatest [m]."""
        (a, b), (_, d) = self.covariance[:2, :2].tolist()
        return math.sqrt(max(0.0, 0.5 * (a + d) + math.hypot(0.5 * (a - d), b)))


def _disturbance(noise: MotionNoise, dt: float) -> Array:
    """(5, 5) What the disturbances of dt [s] add to the covariance."""
    added = np.zeros((5, 5))
    q = noise.acceleration
    for axis in (0, 1):
        added[axis, axis], added[axis + 2, axis + 2] = q * dt**3 / 3.0, q * dt
        added[axis, axis + 2] = added[axis + 2, axis] = q * dt**2 / 2.0
    added[4, 4] = noise.turning * dt
    return added


def _turn_on(state: Array, dt: float, kept: float) -> tuple[Array, Array]:
    """State (5,) after a coordinated turn, and its derivatives (5, 5) by the state before.

    Args:
        state: (5,) State, as in `MotionFilter`.
        dt: Duration of the turn [s].
        kept: Share of the turn rate that is left after it [1].
    """
    x, y, vx, vy, w = state.tolist()
    along, across, d_along, d_across = _turned(w, dt)
    c, s = math.cos(w * dt), math.sin(w * dt)
    moved = x + along * vx - across * vy, y + across * vx + along * vy, c * vx - s * vy, s * vx + c * vy, kept * w
    slope = (
        (1.0, 0.0, along, -across, d_along * vx - d_across * vy),
        (0.0, 1.0, across, along, d_across * vx + d_along * vy),
        (0.0, 0.0, c, -s, -dt * (s * vx + c * vy)),
        (0.0, 0.0, s, c, dt * (c * vx - s * vy)),
        (0.0, 0.0, 0.0, 0.0, kept),
    )
    return np.array(moved), np.array(slope)


def _inverse(matrix: Array) -> Array:
    """Inverse of a positive matrix (2, 2), ten times faster than the general one."""
    (a, b), (c, d) = matrix.tolist()
    scale = 1.0 / (a * d - b * c)
    return np.array([[scale * d, -scale * b], [-scale * c, scale * a]])


def _turned(w: float, dt: float) -> tuple[float, float, float, float]:
    """sin(w dt)/w and (1 - cos(w dt))/w [s], and their derivatives by w [s2]; the limits where w vanishes."""
    angle = w * dt
    if abs(angle) < 1e-4:
        return dt, 0.5 * angle * dt, -angle * dt * dt / 3.0, 0.5 * dt * dt
    c, s = math.cos(angle), math.sin(angle)
    return s / w, (1.0 - c) / w, (angle * c - s) / w**2, (angle * s - 1.0 + c) / w**2
