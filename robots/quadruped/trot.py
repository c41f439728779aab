"""A trot: foot positions of a four-legged body that realise a commanded twist."""

from __future__ import annotations

import math

import numpy as np

from .legs import HIPS, LATERAL, Array

CYCLE = 0.40  # [s] one step of all four legs
STANCE = 0.55  # share of the cycle for which a foot is on the ground; the diagonals overlap by 5 %
LIFT = 0.08  # [m] height of the swing, which clears steps of 4 cm
HEIGHT = 0.28  # [m] of the hips above the feet
OFFSET = np.array([0.0, 0.5, 0.5, 0.0])  # phases of the legs [cycles]: diagonal pairs move together
HOME = HIPS + np.array([np.zeros(4), LATERAL])  # [m] x and y of the feet below the thigh joints, base frame, (2, 4)
REACH = np.array([[0.13], [0.10]])  # [m] maximum distance of a foot from its home
CAPTURE = np.array([[0.06], [0.08]])  # [s] shift of a foothold by a deviation from the commanded velocity
LEVEL, LEVEL_RATE = 0.5, 0.08  # extension of the legs on the low side: per tilt, and per tilt rate [s]
INTEGRAL, INTEGRAL_LIMIT = 1.0, 0.2  # [1/s] and [m/s, rad/s]: correction of the mean twist
RAMP = np.array([2.5, 2.0, 6.0])  # [m/s2, m/s2, rad/s2] maximum change of the twist of the gait
QUIET = np.array([0.03, 0.03, 0.06])  # [m/s, m/s, rad/s] commands below which the legs are to rest
SETTLED = np.array([0.06, 0.06, 0.2])  # motion of the body below which the legs may rest
DISTURBED = np.array([0.25, 0.20, 1.0])  # motion of a standing body above which it steps to catch itself
SPREAD = 0.03  # [m] distance of a foot from its home with which the legs may rest


class Trot:
    """State of the gait. `step` is called once per physics step.

    Args:
        period: Physics step [s].

    Attributes:
        stepping: Whether the legs step; otherwise all four feet stay on the ground.
    """

    def __init__(self, period: float) -> None:
        self.period = period
        self.stepping = False
        self._phase = 0.0  # [cycles]
        self._twist = np.zeros(3)  # of the gait: forward, left [m/s], turn [rad/s]
        self._mean = np.zeros(3)  # of the body, smoothed over a cycle
        self._expected = np.zeros(3)  # commanded, smoothed equally
        self._integral = np.zeros(3)
        self._feet = HOME.copy()  # x and y, base frame [m], shape (2, 4)
        self._lifted = HOME.copy()  # where the feet left the ground
        self._before = np.zeros(4)  # phases of the legs in the last step

    def step(self, wanted: Array, twist: Array, tilt: Array) -> tuple[Array, Array]:
        """Advance the gait by one period.

        Args:
            wanted: Commanded twist: forward, left [m/s], turn [rad/s].
            twist: Measured twist of the body.
            tilt: Measured roll, pitch [rad] and their rates [rad/s].

        Returns:
            Positions x and y of the feet, base frame, shape (2, 4), and z above the hips, shape (4,) [m].
        """
        dt = self.period
        self._mean += (dt / CYCLE) * (twist - self._mean)
        self._expected += (dt / CYCLE) * (wanted - self._expected)
        rest = bool((np.abs(wanted) < QUIET).all())
        if self.stepping and not rest:
            error = (dt * INTEGRAL) * (self._expected - self._mean)
            self._integral = np.clip(self._integral + error, -INTEGRAL_LIMIT, INTEGRAL_LIMIT)
        else:
            self._integral *= 1.0 - dt / 0.2
        aim = self._integral if rest else wanted + self._integral
        self._twist += np.clip(aim - self._twist, -RAMP * dt, RAMP * dt)
        if not self.stepping:
            shaken = (np.abs(twist) > DISTURBED).any() or np.abs(tilt[:2]).max() > 0.2
            if rest and not shaken:
                return self._feet, self._height(tilt, self._feet)
            self.stepping, self._phase = True, 0.0
        return self._walk(rest, twist, tilt)

    def _walk(self, rest: bool, twist: Array, tilt: Array) -> tuple[Array, Array]:
        dt, feet = self.period, self._feet
        previous, self._phase = self._phase, (self._phase + dt / CYCLE) % 1.0
        if rest and math.floor(2.0 * previous) != math.floor(2.0 * self._phase) and self._may_stand(twist):
            self.stepping = False
            self._twist[:] = 0.0
            return feet, self._height(tilt, feet)
        phase = (self._phase + OFFSET) % 1.0
        swing = np.maximum(phase - STANCE, 0.0) / (1.0 - STANCE)
        begins = (swing > 0.0) & (self._before <= STANCE)
        self._lifted[:, begins] = feet[:, begins]
        self._before = phase
        vx, vy, w = self._twist
        moved = feet - dt * np.array([vx - w * feet[1], vy + w * feet[0]])
        # Raibert: half a stance ahead of the home, and farther if the body is faster than commanded.
        ideal = np.array([vx - w * HOME[1], vy + w * HOME[0]])
        fast = np.array([twist[0] - twist[2] * HOME[1], twist[1] + twist[2] * HOME[0]]) - ideal
        target = HOME + (0.5 * STANCE * CYCLE) * ideal + CAPTURE * fast
        angle = 2.0 * math.pi * swing
        there = swing - np.sin(angle) / (2.0 * math.pi)
        flown = self._lifted + (target - self._lifted) * there
        placed = np.where(swing > 0.0, flown, moved)
        self._feet = np.minimum(np.maximum(placed, HOME - REACH), HOME + REACH)
        return self._feet, self._height(tilt, self._feet) + (0.5 * LIFT) * (1.0 - np.cos(angle))

    def _may_stand(self, twist: Array) -> bool:
        near = np.abs(self._feet - HOME).max() < SPREAD
        return bool(near and (np.abs(self._mean) < SETTLED).all())

    def _height(self, tilt: Array, feet: Array) -> Array:
        """Heights of the feet above the hips that level the body [m], shape (4,)."""
        roll, pitch = LEVEL * tilt[:2] + LEVEL_RATE * tilt[2:]
        height: Array = roll * feet[1] - pitch * feet[0] - HEIGHT
        return height
