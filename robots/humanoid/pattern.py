"""Walking pattern of a biped: footholds and motion of the centre of mass, by the linear inverted pendulum.

The divergent component of motion (DCM) is c + v / OMEGA, with position c and velocity v of the centre of mass. It moves
away from the centre of pressure of the foot on the ground exponentially; without a step, the robot falls. Each step
places the foot so that the DCM is where it would be in a steady walk. Source: M. Khadiv et al., Step timing adjustment:
a step toward generating robust gaits, Humanoids 2016; here the timing is fixed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rocs_bt.base.geometry import wrap_angle

from .legs import HIP, Array

OMEGA = math.sqrt(9.81 / 0.56)  # [1/s] of the pendulum; the centre of mass is 0.56 m high
STEP = 0.30  # [s] from a landing to the next
SWING = 0.25  # [s] of it the foot is in the air; then both feet carry the robot
SHIFT = 0.40  # [s] shift of the weight before the first step
LIFT = 0.05  # [m] height of the swing
GROWTH = math.exp(OMEGA * STEP)  # of the DCM in one step
INWARD = 0.015  # [m] from the middle of a sole to the centre of pressure, toward the other foot; less sway
WIDTH = 2.0 * HIP  # [m] distance between the feet
NARROW, WIDE = 0.125, 0.30  # [m] limits of it
LONG = 0.25  # [m] longest step
TWIST = 0.35  # [rad] largest angle between the feet
RAMP = np.array([1.0, 0.8, 4.0])  # [m/s2, m/s2, rad/s2] maximum change of the twist of the gait
QUIET = np.array([0.01, 0.01, 0.03])  # [m/s, m/s, rad/s] commands below which the robot is to rest
INTEGRAL, INTEGRAL_LIMIT = 1.5, np.array([0.12, 0.08, 0.2])  # correction of the mean twist [1/s], [m/s, rad/s]
MEASURED = 0.3  # share of the measured DCM in the choice of footholds; the rest is the pendulum's
OBSERVER = 3.0  # [1/s] by which the pendulum follows the measured centre of mass
STIFF = 1.5  # by which the centre of pressure of a standing robot goes beyond its DCM
CATCH = np.array([0.06, 0.055])  # [m] offset of the DCM ahead and aside, above which a resting robot steps
SETTLED = 0.03  # [m] offset of the DCM and of the feet ahead, below which it may rest
LEFT, RIGHT = 0, 1


def turned(vector: Array, yaw: float) -> Array:
    """A vector in the plane, rotated by a yaw [rad]."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


@dataclass
class Foot:
    """Pose of a sole: position of its middle in the plane [m], height [m] and yaw [rad]."""

    at: Array
    yaw: float = 0.0
    height: float = 0.0


class Pattern:
    """State of the pattern, in a plane of its own that begins under the robot.

    `step` is called once per physics step.

    Args:
        period: Physics step [s].

    Attributes:
        feet: Left and right foot.
        centre: Position of the centre of mass in the plane [m], shape (2,).
        yaw: Yaw of the body [rad].
        stance: Index of the foot that carries the robot.
        stepping: Whether the robot steps or shifts its weight; otherwise it rests on both feet.
    """

    def __init__(self, period: float) -> None:
        self.period = period
        self.feet = (Foot(np.array([0.0, HIP])), Foot(np.array([0.0, -HIP])))
        self.centre, self.yaw, self.stance, self.stepping = np.zeros(2), 0.0, RIGHT, False
        self._velocity, self._first = np.zeros(2), True
        self._time = 0.0  # [s] since the last landing; negative while the weight shifts
        self._lifted = Foot(np.zeros(2))  # where the swinging foot left the ground
        self._target = Foot(np.zeros(2))  # where it lands
        self._twist, self._mean, self._expected, self._integral = np.zeros((4, 3))

    def step(self, wanted: Array, twist: Array, centre: Array, velocity: Array) -> None:
        """Advance the pattern by one period.

        Args:
            wanted: Commanded twist: forward, left [m/s], turn [rad/s].
            twist: Measured twist of the body.
            centre: Measured position of the centre of mass in the plane [m], shape (2,).
            velocity: Its velocity [m/s], shape (2,).
        """
        dt = self.period
        if self._first:
            self.centre, self._first = centre, False
        rest = bool((np.abs(wanted) < QUIET).all())
        self._correct(wanted, twist, rest)
        aim = np.zeros(3) if rest else wanted + self._integral
        self._twist += np.clip(aim - self._twist, -RAMP * dt, RAMP * dt)
        self.centre = self.centre + (dt * OBSERVER) * (centre - self.centre)
        self._velocity = self._velocity + (dt * OBSERVER) * (velocity - self._velocity)
        measured = centre + velocity / OMEGA
        if not self.stepping:
            self._stand(measured, rest)
        elif self._time < 0.0:
            self._shift()
        else:
            self._walk(measured, rest)
        self.yaw += dt * float(self._twist[2])

    def _correct(self, wanted: Array, twist: Array, rest: bool) -> None:
        """Integrate the error of the mean twist."""
        dt = self.period
        share = dt / (2.0 * STEP)
        self._mean += share * (twist - self._mean)
        self._expected += share * (self._twist - self._integral - self._expected)
        if self.stepping and not rest:
            error = (dt * INTEGRAL) * (self._expected - self._mean)
            self._integral = np.clip(self._integral + error, -INTEGRAL_LIMIT, INTEGRAL_LIMIT)
        else:
            self._integral *= 1.0 - dt / 0.3

    def _stand(self, measured: Array, rest: bool) -> None:
        left, right = self.feet
        middle = 0.5 * (left.at + right.at)
        self.yaw += 3.0 * self.period * wrap_angle(0.5 * (left.yaw + right.yaw) - self.yaw)
        dcm = self.centre + self._velocity / OMEGA
        self._pendulum(middle + (1.0 + STIFF) * (dcm - middle))
        off = turned(measured - middle, -self.yaw)
        caught = bool((np.abs(off) > CATCH).any())
        if rest and not caught:
            return
        self.stepping = True
        aside = float(off[1]) if caught else -float(self._twist[1] or self._twist[2])
        self.stance = LEFT if aside > 0.0 else RIGHT
        self._time = -SHIFT
        if caught:
            self._land(self.stance)

    def _shift(self) -> None:
        """Shift the weight over the foot that will carry the robot."""
        left, right = self.feet
        middle, foot = 0.5 * (left.at + right.at), self.feet[self.stance]
        end = self._pressure(foot) + self._offset(self.stance)
        dcm = self.centre + self._velocity / OMEGA
        growth = math.exp(OMEGA * max(-self._time, 0.06))
        pressure = turned((end - growth * dcm) / (1.0 - growth) - middle, -self.yaw)
        self._pendulum(middle + turned(np.clip(pressure, (-0.05, -HIP), (0.07, HIP)), self.yaw))
        self._time += self.period
        if self._time >= 0.0:
            self._land(self.stance)

    def _walk(self, measured: Array, rest: bool) -> None:
        foot, swing = self.feet[self.stance], self.feet[1 - self.stance]
        pressure = self._pressure(foot)
        self._time += self.period
        if self._time < 0.8 * SWING:
            growth = math.exp(OMEGA * (STEP - self._time))
            planned = self.centre + self._velocity / OMEGA - pressure
            dcm = MEASURED * (measured - pressure) + (1.0 - MEASURED) * planned
            self._target = self._foothold(foot, pressure + growth * dcm)
        share = min(self._time / SWING, 1.0)
        angle = 2.0 * math.pi * share
        progress = share - math.sin(angle) / (2.0 * math.pi)
        swing.at = self._lifted.at + progress * (self._target.at - self._lifted.at)
        swing.yaw = self._lifted.yaw + progress * wrap_angle(self._target.yaw - self._lifted.yaw)
        swing.height = 0.5 * LIFT * (1.0 - math.cos(angle))
        self._pendulum(pressure)
        if self._time >= STEP:
            self._land(1 - self.stance)
            if rest and self._may_stand(measured):
                self.stepping = False
                self._twist[:] = 0.0

    def _land(self, stance: int) -> None:
        self.stance, self._time = stance, 0.0
        swing = self.feet[1 - stance]
        swing.height = self.feet[stance].height = 0.0
        self._lifted = Foot(swing.at.copy(), swing.yaw)

    def _may_stand(self, measured: Array) -> bool:
        left, right = self.feet
        apart = turned(left.at - right.at, -self.yaw)
        off = turned(measured - 0.5 * (left.at + right.at), -self.yaw)
        level = abs(apart[0]) < SETTLED and abs(wrap_angle(left.yaw - right.yaw)) < 0.1
        return bool(level and abs(off[0]) < SETTLED and abs(off[1]) < CATCH[1])

    def _pressure(self, foot: Foot) -> Array:
        """Centre of pressure of a foot that carries the robot."""
        inward = -INWARD if foot is self.feet[LEFT] else INWARD
        return foot.at + turned(np.array([0.0, inward]), foot.yaw)

    def _offset(self, stance: int) -> Array:
        """DCM of a steady walk at a landing, from the centre of pressure of the foot that has landed."""
        ahead, left = (STEP * self._twist[:2]).tolist()
        aside = WIDTH - 2.0 * INWARD if stance == RIGHT else 2.0 * INWARD - WIDTH
        return turned(np.array([ahead / (GROWTH - 1.0), left / (GROWTH - 1.0) + aside / (GROWTH + 1.0)]), self.yaw)

    def _foothold(self, foot: Foot, dcm: Array) -> Foot:
        """Foothold of the swinging foot, from the DCM at its landing."""
        next_stance = 1 - self.stance
        turn = float(self._twist[2])
        yaw = self.yaw + turn * (STEP - self._time + 0.5 * STEP)
        yaw = foot.yaw + min(max(wrap_angle(yaw - foot.yaw), -TWIST), TWIST)
        side = 1.0 if next_stance == LEFT else -1.0
        at = dcm - self._offset(next_stance) + turned(np.array([0.0, side * INWARD]), yaw)
        ahead, aside = turned(at - foot.at, -self.yaw).tolist()
        ahead, aside = min(max(ahead, -LONG), LONG), side * min(max(side * aside, NARROW), WIDE)
        return Foot(foot.at + turned(np.array([ahead, aside]), self.yaw), yaw)

    def _pendulum(self, pressure: Array) -> None:
        """Advance the pendulum over a centre of pressure."""
        dt = self.period
        self._velocity = self._velocity + (dt * OMEGA * OMEGA) * (self.centre - pressure)
        self.centre = self.centre + dt * self._velocity
