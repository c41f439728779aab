"""Headings along a path that differ from its tangent, for bodies that move in every direction."""

from __future__ import annotations

import math

import numpy as np

from ..base.geometry import wrap_angle
from .axis import AxisLimits
from .locomotion import Array
from .path import REACH

NEAR = 0.3
"""Distance from a point below which its direction is not followed [m]."""

HALF_TURN = 0.3
"""Angle from the half turn within which a turning robot continues in its direction [rad]."""


def toward(positions: Array, x: float, y: float, otherwise: float) -> Array:
    """Yaws from positions toward a point, without jumps of 2 pi, shape (n,) [rad].

    Where a position is closer to the point than `NEAR`, the yaw is interpolated between the last and the next farther
    position, or held if there is only one of these.

    Args:
        positions: Positions in the order in which they are passed, world frame, shape (n, 2) [m].
        x: Position of the point, world frame [m].
        y: Position of the point, world frame [m].
        otherwise: Yaw if all positions are near the point [rad].
    """
    dx, dy = x - positions[:, 0], y - positions[:, 1]
    far = np.flatnonzero(np.hypot(dx, dy) >= NEAR)
    if len(far) == 0:
        return np.full(len(positions), otherwise)
    yaws = np.unwrap(np.arctan2(dy[far], dx[far]))
    return np.asarray(np.interp(np.arange(len(positions)), far, yaws))


def blended_yaws(yaws: Array, spacing: float, s: float, yaw: float, slope: float) -> Array:
    """Yaws along a path that begin with the robot's yaw and change over to other yaws while the robot drives.

    Args:
        yaws: Yaws to change over to, at each sample of the path, shape (n,) [rad].
        spacing: Arc length between samples [m].
        s: Arc length of the robot [m].
        yaw: Yaw of the robot [rad].
        slope: Maximum additional change of the yaw per arc length, unless the path is too short for it [rad/m].

    Returns:
        Yaws, shape (n,) [rad]; `yaws` itself if the rest of the path is shorter than `REACH`.
    """
    stations = spacing * np.arange(len(yaws))
    error = wrap_angle(yaw - float(np.interp(s, stations, yaws)))
    run = min(0.5 * math.pi * abs(error) / slope, stations[-1] - s)
    if run < REACH:
        return yaws
    share = np.clip((stations - s) / run, -1.0, 1.0)
    return np.asarray(yaws + error * (1.0 - np.sin(0.5 * math.pi * share)))


def limited_yaws(targets: Array, times: Array, yaw: float, turn: float, axis: AxisLimits) -> tuple[Array, Array]:
    """Yaws and turn rates that follow target yaws from the present yaw, in the shorter direction, without a jump.

    Args:
        targets: Target yaws now and at each of the times, without jumps of 2 pi, shape (k + 1,) [rad].
        times: Times from now on, ascending, shape (k,) [s].
        yaw: Present yaw [rad].
        turn: Present turn rate [rad/s].
        axis: Limits of turn rate and angular acceleration.

    Returns:
        Yaws [rad] and turn rates [rad/s] at the times, each of shape (k,).
    """
    error = wrap_angle(float(targets[0]) - yaw)
    if error * turn < 0.0 and abs(error) > math.pi - HALF_TURN:
        error -= math.copysign(math.tau, error)
    return axis.track(targets + (yaw + error - float(targets[0])), times, yaw, turn)
