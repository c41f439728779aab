"""PastScans: the evidence that something moved, from what earlier scans looked past."""

from __future__ import annotations

from collections import deque

import numpy as np
import numpy.typing as npt

from ..locomotion import Array
from .beams import Scan

AGO = 0.4
"""Age of the scan with which a new one is compared [s]; the oldest one while none is as old."""

BEHIND = 0.1
"""Distance behind a point beyond which an echo shows that the point was free [m]."""

SIDE = 2
"""Number of beams on either side of a point that must look past it, too; the edges of objects are uncertain."""

SHARE = 0.2
"""Part of an object's echoes that must be in space that was free, or must have become free."""


class PastScans:
    """Scans of the last `AGO` seconds.

    An object has moved if its echoes are where an earlier scan looked past, or if the new scan looks past its earlier
    echoes. Stationary objects never do that: they may be hidden, merge with a neighbour or come into view, and then
    their estimates move, but no beam passes through them.
    """

    def __init__(self) -> None:
        self._scans: deque[tuple[float, Scan, npt.NDArray[np.int64]]] = deque()

    def add(self, t: float, scan: Scan, owner: npt.NDArray[np.int64]) -> None:
        """Store a scan.

        Args:
            t: Time stamp of the scan [s].
            scan: The scan.
            owner: Number of the track of each beam's echo, 0 for none, shape (b,).
        """
        self._scans.append((t, scan, owner))
        while len(self._scans) > 1 and t - self._scans[1][0] >= AGO - 1e-9:
            self._scans.popleft()

    def moved(self, number: int) -> bool:
        """Whether the track with a number has moved between the oldest and the newest scan."""
        (_, before, old), (_, now, new) = self._scans[0], self._scans[-1]
        here, there = now.points[new == number], before.points[old == number]
        return _share(before, here) >= SHARE or _share(now, there) >= SHARE


def _share(scan: Scan, points: Array) -> float:
    """Part of some points, shape (k, 2) [m], that a scan looked past."""
    if not len(points):
        return 0.0
    middle = len(scan.bearings) // 2
    away = points - scan.eyes[middle]
    turn = np.arctan2(away[:, 1], away[:, 0]) - scan.bearings[middle]
    nearest = middle + np.rint((np.mod(turn + np.pi, 2.0 * np.pi) - np.pi) / scan.beams.spacing).astype(np.intp)
    beams = nearest[:, None] + np.arange(-SIDE, SIDE + 1)
    inside = (beams >= 0) & (beams < len(scan.ranges))
    far = scan.ranges[np.where(inside, beams, 0)] > (np.hypot(away[:, 0], away[:, 1]) + BEHIND)[:, None]
    return float((inside & far).all(axis=1).mean())  # false for NaN
