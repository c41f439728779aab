"""Gaps between the hull and other things: remembered echoes, and the circles around other robots."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rocs_bt import Pose2

Array = npt.NDArray[np.float64]

TURNS = np.linspace(0.0, math.pi, 37)
"""Turns on the spot that are examined [rad]."""

SWING = 0.05
"""Smallest allowed gap to an echo during a turn on the spot [m]."""


def hull_gaps(
    poses: Sequence[Pose2], centres: Sequence[tuple[float, float]], half: tuple[float, float], radius: float
) -> list[float]:
    """Gaps between a moving rectangular hull and a circle, pose by pose [m]; negative where they overlap.

    Args:
        poses: Poses of the hull's centre, world frame.
        centres: Positions of the circle's centre at the same times, world frame [m].
        half: Half the hull's length and width [m].
        radius: Radius of the circle [m].
    """
    found = []
    for (here_x, here_y, yaw), (x, y) in zip(poses, centres, strict=True):
        c, s = math.cos(yaw), math.sin(yaw)
        dx, dy = x - here_x, y - here_y
        ahead, aside = abs(c * dx + s * dy) - half[0], abs(c * dy - s * dx) - half[1]
        away = math.hypot(ahead, aside) if ahead > 0.0 and aside > 0.0 else max(ahead, aside, 0.0)
        found.append(away - radius)
    return found


def least_gaps(points: Array, bearings: Array, half: tuple[float, float], sectors: Array) -> tuple[float, float, float]:
    """Smallest gaps between the hull and points on its left, on its right, and behind it [m].

    A gap behind the hull is divided by the weight of the sector in which the point is.

    Args:
        points: Positions in the hull's frame [m], shape (k, 2).
        bearings: Bearings of these points [rad], shape (k,).
        half: Half the hull's length and width [m].
        sectors: Largest angle off the rear axis [rad] and weight of each sector, in order of the angles, shape (n, 2).
    """
    outside = np.maximum(np.abs(points) - half, 0.0)
    gaps, off = np.hypot(outside[:, 0], outside[:, 1]), np.abs(bearings)
    beside, to_left, aside = off <= 0.5 * math.pi, bearings >= 0.0, math.pi - off
    ends, weights = sectors.T
    near = aside <= ends[-1]
    behind = gaps[near] / weights[ends.searchsorted(aside[near])]
    left, right = gaps[beside & to_left], gaps[beside & ~to_left]
    return float(left.min(initial=math.inf)), float(right.min(initial=math.inf)), float(behind.min(initial=math.inf))


def free_turns(points: Array, half: tuple[float, float]) -> tuple[float, float]:
    """Free turns on the spot to the left and to the right [rad]: until the hull comes nearer to a point than `SWING`.

    A hull that is already nearer to a point may turn away from the point.

    Args:
        points: Positions in the hull's frame [m], shape (k, 2).
        half: Half the hull's length and width [m].
    """
    near = points[np.hypot(points[:, 0], points[:, 1]) < math.hypot(*half) + SWING]
    return (_free_turn(near, half), _free_turn(near * (1.0, -1.0), half)) if len(near) else (math.pi, math.pi)


def _free_turn(points: Array, half: tuple[float, float]) -> float:
    """Angle by which the hull can turn left in place before a gap to a point gets too small [rad]; pi if none does."""
    x, y = points.T
    c, s = np.cos(TURNS)[:, None], np.sin(TURNS)[:, None]
    ahead, aside = np.abs(c * x + s * y) - half[0], np.abs(c * y - s * x) - half[1]
    inside = np.minimum(np.maximum(ahead, aside), 0.0)  # negative, so that a hull that touches a point turns away
    gaps = np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0)) + inside
    hit = (gaps < np.minimum(gaps[0], SWING) - 1e-9).any(axis=1)
    return float(TURNS[hit.argmax() - 1]) if hit.any() else math.pi
