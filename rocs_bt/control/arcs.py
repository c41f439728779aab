"""The ways on which a robot asks how much ground is free: what monitors measure and actions choose from."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..geometry import Pose2, Twist2, along_arc
from .drive import Array

BENDS = (-1.5, -0.6, 0.0, 0.6, 1.5)
"""Curvatures, left positive when the robot drives ahead [rad/m]; the signals of room have one value for each."""

STRAIGHT = BENDS.index(0.0)

HEADINGS = np.linspace(-math.pi, math.pi, 12, endpoint=False)
"""Headings in the world frame to which a robot may turn its nose or stern on the spot before it drives there [rad]."""

_EPSILON = float(np.finfo(float).eps)


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


def turned_edges(half: tuple[float, float], runs: Array) -> Array:
    """(n, k, 5, 2) Where the hull's leading edge comes after each run, turned to each heading, in points.

    Args:
        half: Half the hull's length and width [m].
        runs: (k,) How far it drives [m].
    """
    x, y = np.moveaxis(leading_edges(half, runs)[0, STRAIGHT], -1, 0)
    c, s = np.cos(HEADINGS)[:, None, None], np.sin(HEADINGS)[:, None, None]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def along(motions: Sequence[tuple[Pose2, Twist2]], durations: Array) -> Array:
    """(p, k, 3) Where constant body twists lead in each of some whiles (p, k) [s]: `geometry.arc` for many at once."""
    x, y, yaw, forward, turn, left = np.array([(*pose, *twist) for pose, twist in motions]).T[:, :, None]
    found = np.empty((*durations.shape, 3))
    half = 0.5 * turn * durations
    chord, middle = durations * sinc(half / math.pi), yaw + half
    c, s = chord * np.cos(middle), chord * np.sin(middle)
    found[..., 0] = x + forward * c - left * s
    found[..., 1] = y + forward * s + left * c
    found[..., 2] = middle + half
    return found


def sinc(x: Array) -> Array:
    """sin(pi x) / (pi x), and 1 at 0: `numpy.sinc` to the bit, in half the time for a few dozen numbers."""
    angle = math.pi * x
    np.putmask(angle, angle == 0.0, _EPSILON)
    ratio: Array = np.sin(angle) / angle
    return ratio
