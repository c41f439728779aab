"""Gaps between a hull and remembered echoes."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..compiled import compiled

Array = npt.NDArray[np.float64]


@compiled
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
