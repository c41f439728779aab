"""Kinematics of four equal legs with three joints each: abduction, thigh and knee."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

THIGH, SHIN = 0.213, 0.213  # [m] lengths; sources of all dimensions are in robot.xml
LATERAL = np.array([0.08, -0.08, 0.08, -0.08])  # [m] from the abduction axis to the plane of the leg, left positive
HIPS = np.array([[0.1881, 0.1881, -0.1881, -0.1881], [0.04675, -0.04675, 0.04675, -0.04675]])  # [m] x and y in the base
FACING = np.array([1.0, 1.0, -1.0, -1.0])  # rear legs are mounted the other way round, knees to the middle
MAX_LENGTH = 0.38  # [m] from the thigh joint to the foot; the limit of the knee allows 0.385 m
MIN_LENGTH = 0.10  # [m]


def joint_angles(x: Array, y: Array, z: Array) -> Array:
    """Inverse kinematics of all legs.

    Args:
        x: Positions of the feet ahead of the hips [m], shape (4,); front left, front right, rear left, rear right.
        y: Positions to the left of the hips [m], shape (4,).
        z: Positions above the hips [m], shape (4,); negative.

    Returns:
        Joint angles [rad], shape (12,): abduction, thigh and knee of each leg. Feet out of reach are approximated.
    """
    down = np.sqrt(np.maximum(y * y + z * z - LATERAL * LATERAL, 1e-4))  # in the plane of the leg
    abduction = np.arctan2(z, y) + np.arctan2(down, LATERAL)
    squared = np.minimum(np.maximum(x * x + down * down, MIN_LENGTH**2), MAX_LENGTH**2)
    knee = -np.arccos((squared - (THIGH**2 + SHIN**2)) / (2.0 * THIGH * SHIN))
    thigh = np.arctan2(-FACING * x, down) - np.arctan2(SHIN * np.sin(knee), THIGH + SHIN * np.cos(knee))
    return np.stack((abduction, thigh, knee), axis=1).ravel()


def foot_positions(angles: Array) -> tuple[Array, Array, Array]:
    """Forward kinematics: positions x, y, z of the feet from their hips [m], each of shape (4,).

    Args:
        angles: Joint angles [rad], shape (12,), as of `joint_angles`.
    """
    abduction, thigh, knee = angles.reshape(4, 3).T
    x = -FACING * (THIGH * np.sin(thigh) + SHIN * np.sin(thigh + knee))
    down = THIGH * np.cos(thigh) + SHIN * np.cos(thigh + knee)
    c, s = np.cos(abduction), np.sin(abduction)
    return x, LATERAL * c + down * s, LATERAL * s - down * c
