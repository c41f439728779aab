"""The ways on which a robot asks how much ground is free: what monitors measure and actions choose from."""

from __future__ import annotations

import math

import numpy as np

from ..geometry import Pose2, Twist2, along_arc
from .drive import Array

BENDS = (-1.5, -0.6, 0.0, 0.6, 1.5)
"""Curvatures, left positive when the robot drives ahead [rad/m]; the signals of room have one value for each."""

STRAIGHT = BENDS.index(0.0)


def leading_edges(half: tuple[float, float], runs: Array) -> Array:
    """(2, n, k, 5, 2) Where the hull's leading edge comes: ahead and back, on each bend, after each run, in points.

    Args:
        half: Half the hull's length and width [m].
        runs: (k,) How far it drives [m].
    """
    found = []
    for sign in (1.0, -1.0):
        for bend in BENDS:
            for run in runs.tolist():
                here = along_arc(Pose2(0.0, 0.0), Twist2(sign, sign * bend), run)
                found.append([here.transform(sign * half[0], share * half[1]) for share in (-1.0, -0.5, 0.0, 0.5, 1.0)])
    return np.array(found).reshape(2, len(BENDS), len(runs), 5, 2)


def along(pose: Pose2, twist: Twist2, durations: Array) -> Array:
    """(k, 3) Where a constant body twist leads in each of some whiles [s]: `geometry.arc` for many of them."""
    half = 0.5 * twist.turn * durations
    chord, yaw = durations * np.sinc(half / math.pi), pose.yaw + half
    c, s = chord * np.cos(yaw), chord * np.sin(yaw)
    x, y = pose.x + twist.forward * c - twist.left * s, pose.y + twist.forward * s + twist.left * c
    return np.stack([x, y, yaw + half], axis=1)
