"""Predicted motion that meets static obstacles: nothing that walks passes through a wall; it follows it, or stops."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from .locomotion import Array
from .way_field import WayField

STRIDE = 0.2
"""Greatest distance between two points of a motion that are checked [m]."""

LEAST_GAP, SLACK = 0.1, 0.03
"""Gap to which a mover that is even nearer may come again [m], and inaccuracy of the gaps [m]."""

PROBE, AROUND = 0.1, np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
"""Distance of the points around a place from which the direction of a wall is measured [m], and their directions."""


def follow(walls: WayField, start: Array, positions: Array, radius: Array) -> None:
    """Lead predicted motions along the walls into which they would run, up to a corner.

    Args:
        walls: Obstacles that do not move.
        start: Present positions, world frame, shape (m, 2) [m].
        positions: Predicted positions, shape (m, k, 2) [m]; those that would be in a wall, or behind one, are changed.
        radius: Radii of the movers, shape (m,) [m].
    """
    if not positions.size:
        return
    room = np.clip(walls.gap(*start.T) - SLACK, LEAST_GAP, radius)
    steps = np.diff(positions, axis=1, prepend=start[:, None])
    parts = max(math.ceil(float(np.hypot(steps[..., 0], steps[..., 1]).max()) / STRIDE), 1)
    path = (positions - steps)[:, :, None] + steps[:, :, None] * ((np.arange(parts) + 1.0) / parts)[:, None]
    path = path.reshape(len(positions), -1, 2)
    blocked = walls.gap(path[..., 0], path[..., 1]) < room[:, None]
    rows = np.flatnonzero(blocked.any(axis=1))
    if len(rows):
        positions[rows] = _led(walls, start[rows], path[rows], blocked[rows], room[rows])[:, parts - 1 :: parts]


def _led(walls: WayField, start: Array, path: Array, blocked: npt.NDArray[np.bool_], room: Array) -> Array:
    """Paths of m movers, shape (m, n, 2), that reach a wall: to it, then along it with what is left of the speed."""
    first = blocked.argmax(axis=1)
    at = np.concatenate([start[:, None], path], axis=1)[np.arange(len(path)), first]
    east, west, north, south = walls.gap(*(at + PROBE * AROUND[:, None]).transpose(2, 0, 1))
    along = np.stack([south - north, east - west], axis=1)
    along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    slid = at[:, None] + ((path - at[:, None]) @ along[..., None]) * along[:, None]
    led = np.where((np.arange(path.shape[1]) >= first[:, None])[..., None], slid, path)
    into = walls.gap(led[..., 0], led[..., 1]) < room[:, None] - SLACK
    # In a corner it stops: at the last point before the first one that is in a wall.
    last = np.where(into.any(axis=1), into.argmax(axis=1), path.shape[1])
    rows = np.concatenate([start[:, None], led], axis=1)
    index = np.minimum(np.arange(path.shape[1]) + 1, last[:, None])
    held: Array = np.take_along_axis(rows, index[..., None], axis=1)
    return held
