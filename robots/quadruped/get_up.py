"""Getting up after a fall: fold the legs, turn the trunk over with the legs of one side, and stretch the legs.

The poses were found by random search, in a copy of the model in which the legs touch each other and the trunk.
"""

from __future__ import annotations

import numpy as np

from .legs import HIPS, Array, joint_angles
from .trot import HEIGHT, HOME

FALLEN = 0.5  # cosine of the tilt below which the robot has fallen
SIDE, LEVEL = -0.3, 0.8  # cosines of the tilt between back and side, and between side and feet
STILL, REST_TIME = 0.5, 0.1  # [rad/s] and [s]: rotation of a body at rest, and its duration
TURN_SPEED, RISE_SPEED = 13.0, 5.0  # [rad/s] of the targets of the servos
FOLD_TIME, TURN_TIME, RISE_TIME = 1.0, 1.3, 0.45  # [s] for a phase, at most
PASSED = 0.4  # [rad] from the target of the front legs, from which the rear legs follow: they must not meet


def _pose(left: tuple[float, float, float], right: tuple[float, float, float]) -> Array:
    """Joint angles [rad], shape (12,), from abduction outward, thigh and knee of the legs of each side."""
    (a, *left_leg), (b, *right_leg) = left, right
    return np.array(2 * [a, *left_leg, -b, *right_leg])


FOLDED = _pose((0.3, 0.7, -2.4), (0.3, 0.7, -2.4))
STANDING = joint_angles(HOME[0] - HIPS[0], HOME[1] - HIPS[1], np.full(4, -HEIGHT))
FROM_BACK = _pose((0.65, 4.4, -2.4), (0.0, 3.25, -2.7))  # the left legs push
FROM_RIGHT = _pose((0.55, 2.5, -2.0), (-0.15, -0.6, -1.75))
EXCHANGED = np.arange(12).reshape(2, 2, 3)[:, ::-1].ravel()  # left and right legs
FRONT = np.arange(12) < 6


def _mirrored(pose: Array) -> Array:
    """The pose with left and right exchanged."""
    mirrored: Array = np.tile([-1.0, 1.0, 1.0], 4) * pose[EXCHANGED]
    return mirrored


class GetUp:
    """State of the sequence. `step` is called once per physics step, from the fall until it returns True.

    Args:
        period: Physics step [s].
        angles: Targets of the servos when the robot fell [rad], shape (12,).

    Attributes:
        angles: Present targets of the servos [rad], shape (12,).
    """

    def __init__(self, period: float, angles: Array) -> None:
        self.period = period
        self.angles = angles
        self._phase, self._time, self._rest, self._attempts = "fold", 0.0, 0.0, 0

    def step(self, wanted: bool, roll: float, up: float, rate: float) -> bool:
        """Advance the sequence by one period.

        Args:
            wanted: Whether the robot is to get up; otherwise its legs stay folded.
            roll: Roll of the body [rad].
            up: Cosine of its tilt.
            rate: Rotation of the body [rad/s].

        Returns:
            Whether the robot is on its feet.
        """
        self._time += self.period
        if self._phase == "fold":
            folded = self._move(FOLDED, TURN_SPEED)
            self._rest = self._rest + self.period if rate < STILL else 0.0
            if wanted and folded and (self._rest > REST_TIME or self._time > FOLD_TIME):
                self._begin("rise" if up > LEVEL else "turn")
        elif self._phase == "turn":
            self._move(self._turning(roll, up), TURN_SPEED)
            if up > LEVEL or self._time > TURN_TIME:
                self._attempts += up <= LEVEL
                self._begin("fold")
        else:
            self._move(STANDING, RISE_SPEED)
            if up < LEVEL:
                self._begin("fold")
            return self._time > RISE_TIME
        return False

    def _begin(self, phase: str) -> None:
        self._phase, self._time = phase, 0.0

    def _turning(self, roll: float, up: float) -> Array:
        """Pose that turns the trunk over; attempts from the back alternate between both sides."""
        if up > SIDE:
            return FROM_RIGHT if roll > 0.0 else _mirrored(FROM_RIGHT)
        return _mirrored(FROM_BACK) if self._attempts % 2 else FROM_BACK

    def _move(self, pose: Array, speed: float) -> bool:
        """Move the targets of the servos toward a pose, front legs first; returns whether it is reached."""
        change = pose - self.angles
        if np.abs(change[FRONT]).max() > PASSED:
            change = np.where(FRONT, change, 0.0)
        limit = speed * self.period
        self.angles = self.angles + np.clip(change, -limit, limit)
        return bool(np.abs(pose - self.angles).max() < 1e-6)
