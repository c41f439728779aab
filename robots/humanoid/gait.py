"""Gait of the humanoid: position servos follow a walking pattern, which realises body twists."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rocs_bt.devices.mujoco import MujocoActuator

from .legs import ANKLE, HIP, Array, joint_angles, rotation
from .pattern import Pattern, turned

LEGS = ("left", "right")
JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
HEIGHT = 0.53  # [m] of the hips over the soles
FOOT = 0.02  # [m] from the ankle to the middle of the sole, forward
LEVEL, LEVEL_RATE, LEAN = 0.5, 0.05, 0.15  # correction of the body's tilt: per tilt, per tilt rate [s], limit [rad]
SMOOTH = 0.02  # [s] of the measured velocity
NEAR = 0.005  # [m] height of a foot over the ground below which the placement changes gradually
FALLEN = 0.5  # cosine of the tilt below which the servos hold their angles


class Gait(MujocoActuator):
    """Body twists: forward, left [m/s] and turn [rad/s]; without a command the robot rests on both feet.

    The inner loop measures tilt, twist and centre of mass, which a real robot estimates by its inertial sensor, its
    joint encoders and the model of its body. Here they are the simulator's ground truth.
    """

    size = 3

    def set_up(self) -> None:
        """Find the body and the servos in the model."""
        world, robot = self.world, self.robot
        self._servos = world.controls(robot, [f"{leg}_{joint}" for leg in LEGS for joint in JOINTS])
        base = world.model.joint(f"{robot}/base")
        q, v = int(base.qposadr[0]), int(base.dofadr[0])
        data, body = world.data, world.model.body(f"{robot}/base").id
        self._attitude, self._velocity = data.qpos[q + 3 : q + 7], data.qvel[v : v + 6]
        self._position, self._mass = data.xpos[body], data.subtree_com[body]
        feet = [world.model.body(f"{robot}/{leg}_foot").id for leg in LEGS]
        self._feet = [(data.xpos[foot], data.xmat[foot]) for foot in feet]
        self._pattern = Pattern(world.step)
        self._wanted = np.zeros(3)
        self._before = np.full(2, math.nan)  # [m] centre of mass in the last step
        self._speed = np.zeros(2)  # [m/s] of the centre of mass, smoothed
        self._share = min(world.step / SMOOTH, 1.0)

    def command(self, values: Sequence[float]) -> None:
        self._wanted = np.array(values, dtype=float)

    def neutral(self) -> None:
        self._wanted = np.zeros(3)

    def before_step(self, t: float) -> None:
        """Set the angles of all servos for the next physics step."""
        if math.isnan(self._before[0]):  # MuJoCo has computed no positions yet
            rest = np.array([-FOOT, 0.0, HEIGHT, 0.0, 0.0])
            self._set_angles(rest, rest)
            self._before = np.full(2, math.inf)
            return
        pattern = self._pattern
        w, i, j, k = self._attitude.tolist()
        if 1.0 - 2.0 * (i * i + j * j) < FALLEN:
            return
        x, y, _, roll_rate, pitch_rate, turn = self._velocity.tolist()
        yaw = math.atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k))
        roll, pitch = 2.0 * (w * i + j * k), 2.0 * (w * j - k * i)
        twist = np.array([*turned(np.array([x, y]), -yaw), turn])
        mass = self._mass[:2].copy()
        if math.isfinite(self._before[0]):
            self._speed += self._share * ((mass - self._before) / self.world.step - self._speed)
        self._before = mass
        # From the world into the plane of the pattern, by the foot that carries the robot.
        foot, (at, matrix) = pattern.feet[pattern.stance], self._feet[pattern.stance]
        sole = at[:2] + FOOT * matrix[[0, 3]]
        rotate = foot.yaw - math.atan2(matrix[3], matrix[0])
        there = np.array([*(foot.at + turned(self._position[:2] - sole, rotate)), self._position[2] - at[2] + ANKLE])
        pattern.step(self._wanted, twist, foot.at + turned(mass - sole, rotate), turned(self._speed, rotate))
        hips = pattern.centre - turned(mass - self._position[:2], rotate)
        level = np.clip(LEVEL * np.array([roll, pitch]) + LEVEL_RATE * np.array([roll_rate, pitch_rate]), -LEAN, LEAN)
        self._set_angles(np.array([*hips, HEIGHT, *-level]), np.array([*there, roll, pitch]))

    def _set_angles(self, wanted: Array, found: Array) -> None:
        """Set the angles of all servos.

        A foot on the ground moves the base to the wanted pose. A foot in the air is placed relative to the measured
        pose, with a gradual transition near the ground.

        Args:
            wanted: Position of the base in the plane of the pattern [m], roll and pitch [rad], shape (5,).
            found: The same as measured.
        """
        angles: list[float] = []
        for foot, side in zip(self._pattern.feet, (HIP, -HIP), strict=True):
            pose = wanted + min(foot.height / NEAR, 1.0) * (found - wanted)
            roll, pitch = pose[3:].tolist()
            attitude, sole = rotation(roll, pitch, self._pattern.yaw), rotation(0.0, 0.0, foot.yaw)
            ankle = np.array([*foot.at, foot.height + ANKLE]) - pose[:3] - FOOT * sole[:, 0]
            angles += joint_angles(ankle @ attitude - (0.0, side, 0.0), attitude.T @ sole)
        self.world.set_controls(self._servos, angles)
