"""Kinematics of two equal legs with six joints each: three in the hip, the knee, and two in the ankle."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

THIGH, SHIN = 0.26, 0.26  # [m] lengths; robot.xml explains all dimensions
HIP = 0.075  # [m] from the middle of the body to a hip, to the side
ANKLE = 0.05  # [m] height of the ankle over the sole
MAX_LENGTH = 0.515  # [m] from the hip to the ankle, with the knee almost straight
MIN_LENGTH = 0.25  # [m]


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """Rotation matrix Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3)."""
    (a, b, c), (d, e, f) = map(math.cos, (yaw, pitch, roll)), map(math.sin, (yaw, pitch, roll))
    return np.array(
        [
            [a * b, a * e * f - d * c, a * e * c + d * f],
            [d * b, d * e * f + a * c, d * e * c - a * f],
            [-e, b * f, b * c],
        ]
    )


def joint_angles(ankle: Array, foot: Array) -> list[float]:
    """Inverse kinematics of a leg with axes that meet in the hip and in the ankle.

    Args:
        ankle: Position of the ankle from the hip [m], base frame, shape (3,).
        foot: Rotation matrix of the foot in the base, shape (3, 3).

    Returns:
        Hip yaw, roll and pitch, knee, ankle pitch and roll [rad]. Feet out of reach are approximated.
    """
    x, y, z = (-ankle @ foot).tolist()  # the hip, seen from the foot
    length = min(max(math.sqrt(x * x + y * y + z * z), MIN_LENGTH), MAX_LENGTH)
    knee = math.pi - math.acos((THIGH * THIGH + SHIN * SHIN - length * length) / (2.0 * THIGH * SHIN))
    ankle_roll = math.atan2(y, z)
    ankle_pitch = -math.atan2(x, math.hypot(y, z)) - math.atan2(THIGH * math.sin(knee), SHIN + THIGH * math.cos(knee))
    # What is left for the hip is Rz(yaw) Rx(roll) Ry(pitch).
    hip = foot @ rotation(-ankle_roll, 0.0, 0.0) @ rotation(0.0, -ankle_pitch - knee, 0.0)
    yaw = math.atan2(-hip[0, 1], hip[1, 1])
    roll = math.atan2(hip[2, 1], math.hypot(hip[0, 1], hip[1, 1]))
    pitch = math.atan2(-hip[2, 0], hip[2, 2])
    return [yaw, roll, pitch, knee, ankle_pitch, ankle_roll]
