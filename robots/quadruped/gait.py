"""Gait of the quadruped: position servos follow a trot, which realises body twists, or the robot gets up."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rocs_bt.devices.mujoco import MujocoActuator

from .get_up import FALLEN, GetUp
from .legs import HIPS, Array, joint_angles
from .trot import QUIET, Trot

LEGS = ("front_left", "front_right", "rear_left", "rear_right")
JOINTS = ("abduction", "thigh", "knee")


class Gait(MujocoActuator):
    """Body twists: forward, left [m/s] and turn [rad/s]; without a command the legs do not step.

    After a fall the robot folds its legs. The next command to move makes it get up, and then walk.

    The inner loop measures twist and tilt of the body, which a real robot estimates by its inertial sensor and its
    joint encoders. Here they are the simulator's ground truth.
    """

    size = 3

    def set_up(self) -> None:
        """Find the body and the servos in the model."""
        world = self.world
        self._servos = world.controls(self.robot, [f"{leg}_{joint}" for leg in LEGS for joint in JOINTS])
        base = world.model.joint(f"{self.robot}/base")
        q, v = int(base.qposadr[0]), int(base.dofadr[0])
        self._attitude, self._velocity = world.data.qpos[q + 3 : q + 7], world.data.qvel[v : v + 6]
        self._trot = Trot(world.step)
        self._get_up: GetUp | None = None
        self._angles = np.zeros(12)  # targets of the servos [rad]
        self._wanted = np.zeros(3)

    def command(self, values: Sequence[float]) -> None:
        self._wanted = np.array(values, dtype=float)

    def neutral(self) -> None:
        self._wanted = np.zeros(3)

    def before_step(self, t: float) -> None:
        """Set the angles of all servos for the next physics step."""
        if not self._lies():
            twist, tilt = self._motion()
            feet, height = self._trot.step(self._wanted, twist, tilt)
            x, y = feet - HIPS
            self._angles = joint_angles(x, y, height)
        self.world.set_controls(self._servos, self._angles)

    def _lies(self) -> bool:
        """Whether the robot lies or gets up; then the angles of all servos are set for that."""
        w, i, j, k = self._attitude.tolist()
        up = 1.0 - 2.0 * (i * i + j * j)
        if self._get_up is None:
            if up > FALLEN:
                return False
            self._get_up = GetUp(self._trot.period, self._angles)
        wanted, roll = bool((np.abs(self._wanted) > QUIET).any()), math.atan2(2.0 * (w * i + j * k), up)
        if self._get_up.step(wanted, roll, up, float(np.linalg.norm(self._velocity[3:]))):
            self._get_up, self._trot = None, Trot(self._trot.period)
            return False
        self._angles = self._get_up.angles
        return True

    def _motion(self) -> tuple[Array, Array]:
        """Twist (forward, left [m/s], turn [rad/s]), and roll, pitch [rad] with their rates [rad/s]."""
        w, i, j, k = self._attitude.tolist()
        x, y, _, roll_rate, pitch_rate, turn = self._velocity.tolist()
        # The body's x axis, projected onto the plane of the world.
        ahead, aside = 1.0 - 2.0 * (j * j + k * k), 2.0 * (i * j + w * k)
        length = max((ahead * ahead + aside * aside) ** 0.5, 1e-6)
        c, s = ahead / length, aside / length
        roll = 2.0 * (w * i + j * k)
        pitch = 2.0 * (w * j - k * i)
        return np.array([c * x + s * y, c * y - s * x, turn]), np.array([roll, pitch, roll_rate, pitch_rate])
