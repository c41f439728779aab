"""Points that the leading edge of the hull (front edge ahead, rear edge in reverse) reaches on candidate paths."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rocs_bt import Pose2, Twist2
from rocs_bt.base.geometry import along_arc
from rocs_bt.control.arcs import BENDS, HEADINGS, STRAIGHT

Array = npt.NDArray[np.float64]


def leading_edges(half: tuple[float, float], runs: Array) -> Array:
    """Points on the hull's leading edge after driving each distance on each of `rocs_bt.control.arcs.BENDS`.

    Args:
        half: Half the length and half the width of the hull [m].
        runs: Distances driven, shape (k,) [m].

    Returns:
        Points in the initial body frame, shape (2, n, k, 5, 2) [m]: direction (forward, backward), arc, distance,
        point, coordinate.
    """
    found = []
    for sign in (1.0, -1.0):
        for bend in BENDS:
            for run in runs.tolist():
                here = along_arc(Pose2(0.0, 0.0), Twist2(sign, sign * bend), run)
                found.append([here.transform(sign * half[0], share * half[1]) for share in (-1.0, -0.5, 0.0, 0.5, 1.0)])
    return np.array(found).reshape(2, len(BENDS), len(runs), 5, 2)


def turned_edges(half: tuple[float, float], runs: Array) -> Array:
    """Points on the hull's front edge after a turn to each of `rocs_bt.control.arcs.HEADINGS` and each distance.

    Args:
        half: Half the length and half the width of the hull [m].
        runs: Distances driven, shape (k,) [m].

    Returns:
        Points relative to the robot's position, world axes, shape (n, k, 5, 2) [m].
    """
    x, y = np.moveaxis(leading_edges(half, runs)[0, STRAIGHT], -1, 0)
    c, s = np.cos(HEADINGS)[:, None, None], np.sin(HEADINGS)[:, None, None]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)
