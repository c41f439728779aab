"""Gaps between a hull and remembered echoes."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

TURNS = np.linspace(0.0, math.pi, 37)
"""How far round it looks, and how fine [rad]."""

SWING = 0.05
"""A turn on the spot brings the hull no nearer to an echo [m]."""


def least_gaps(points: Array, bearings: Array, half: tuple[float, float], sectors: Array) -> tuple[float, float, float]:
    """The least gap [m] between a hull and some points on its left, on its right, and behind over its sector's weight.

    Args:
        points: (k, 2) In the hull's frame [m].
        bearings: (k,) Theirs [rad].
        half: Half the hull's length and width [m].
        sectors: (n, 2) How far off the axis each ends [rad], and its weight.
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
    """How far a hull may turn on the spot, to the left and to the right, before it comes too near to a point [rad].

    What it is too near to already it may turn from.

    Args:
        points: (k, 2) In the hull's frame [m].
        half: Half the hull's length and width [m].
    """
    near = points[np.hypot(points[:, 0], points[:, 1]) < math.hypot(*half) + SWING]
    return (_free_turn(near, half), _free_turn(near * (1.0, -1.0), half)) if len(near) else (math.pi, math.pi)


def _free_turn(points: Array, half: tuple[float, float]) -> float:
    """The same to the left alone."""
    x, y = points.T
    c, s = np.cos(TURNS)[:, None], np.sin(TURNS)[:, None]
    ahead, aside = np.abs(c * x + s * y) - half[0], np.abs(c * y - s * x) - half[1]
    inside = np.minimum(np.maximum(ahead, aside), 0.0)  # a hull that touches something must not turn into it
    gaps = np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0)) + inside
    hit = (gaps < np.minimum(gaps[0], SWING) - 1e-9).any(axis=1)
    return float(TURNS[hit.argmax() - 1]) if hit.any() else math.pi
