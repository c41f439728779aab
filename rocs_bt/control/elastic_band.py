"""Elastic-band path smoothing: makes a path smooth and keeps the robot's hull in the middle between obstacles.

Sources: Quinlan and Khatib, Elastic bands: connecting path planning and control, ICRA 1993; Kass, Witkin and
Terzopoulos, Snakes: active contour models, International Journal of Computer Vision 1, 1988 (implicit steps).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .footprint import Footprint
from .locomotion import Array

STEP = 0.1
"""Distance between the points of a path [m]."""

ROUNDS, STIFF, PUSH = 25, 20.0, 0.02
"""First relaxation: number of iterations, stiffness of the band, largest push on a point of the hull's outline [m]."""

RIM, ROOM = 12, 0.3
"""Number of points on the hull's outline that obstacles push, and the gap below which they push [m]."""

FITTED, SUPPLE, FIT, FIT_PUSH, SHARP = 20, 2.0, 0.08, 0.01, 0.005
"""Second relaxation, with the exact positions of obstacles nearer than FIT [m]: number of iterations, stiffness, FIT,
largest push [m], and the additional distance at which an obstacle has 1/e of the nearest one's weight [m]."""


@dataclass(frozen=True, eq=False)
class DistanceField:
    """Distances to obstacles in a rectangle of cells; rows go north, columns east.

    Attributes:
        x: Western edge, world frame [m].
        y: Southern edge, world frame [m].
        cell_size: Side of a cell [m].
        distance: Distance from each cell's centre to the nearest obstacle, shape (rows, columns) [m].
        points: Positions of the obstacles, world frame, shape (k, 2) [m].
    """

    x: float
    y: float
    cell_size: float
    distance: Array
    points: Array

    def cell(self, point: Array) -> tuple[int, int] | None:
        """Row and column of the cell at a position (2,) [m]; None outside the grid."""
        row, column = int((point[1] - self.y) // self.cell_size), int((point[0] - self.x) // self.cell_size)
        inside = 0 <= row < self.distance.shape[0] and 0 <= column < self.distance.shape[1]
        return (row, column) if inside else None

    def centres(self) -> Array:
        """Centres of all cells, world frame, shape (rows, columns, 2) [m]."""
        rows, columns = np.indices(self.distance.shape)
        return np.stack([self.x + (columns + 0.5) * self.cell_size, self.y + (rows + 0.5) * self.cell_size], axis=-1)

    def sample(self, grid: Array, points: Array) -> Array:
        """Bilinear interpolation of a grid (rows, columns, ...) at points (k, 2) [m], shape (k, ...)."""
        rows, columns = grid.shape[:2]
        at = (points - (self.x, self.y)) / self.cell_size - 0.5
        u, v = np.clip(at[:, 0], 0.0, columns - 1.001), np.clip(at[:, 1], 0.0, rows - 1.001)
        i, j = v.astype(np.intp), u.astype(np.intp)
        u, v = u - j, v - i
        if grid.ndim == 3:
            u, v = u[:, None], v[:, None]
        flat, at = grid.reshape(rows * columns, *grid.shape[2:]), i * columns + j
        low = (1.0 - u) * flat.take(at, axis=0) + u * flat.take(at + 1, axis=0)
        at += columns
        values: Array = (1.0 - v) * low + v * ((1.0 - u) * flat.take(at, axis=0) + u * flat.take(at + 1, axis=0))
        return values


def headings(points: Array) -> Array:
    """Headings along a path (k, 2) of two or more points, shape (k,) [rad]."""
    chord = np.vstack([points[1:2] - points[:1], points[2:] - points[:-2], points[-1:] - points[-2:-1]])
    return np.arctan2(chord[:, 1], chord[:, 0])


def relaxed(around: DistanceField, footprint: Footprint, points: Array, fixed: int) -> Array:
    """Smooth a path as an elastic band, from which obstacles near the hull push the robot away.

    Args:
        around: Obstacles around the path.
        footprint: Hull of the robot.
        points: Path at steps of about `STEP` [m], shape (k, 2).
        fixed: Number of initial points that do not move; the first and the last point never move.

    Returns:
        Relaxed path [m], shape (k, 2).
    """
    first = max(fixed, 1)
    from scipy.linalg import cho_solve_banded

    if len(points) < first + 3:
        return points
    north, east = np.gradient(around.distance, around.cell_size)
    grids, band, rim = np.stack([around.distance, east, north], axis=-1), points.copy(), _rim(footprint)
    factor, bound = _stiff(len(points), first, STIFF)
    for ease in np.linspace(1.0, 0.2, ROUNDS):
        heading = headings(band)
        ahead = np.column_stack([np.cos(heading), np.sin(heading)])
        aside = ahead[:, ::-1] * (-1.0, 1.0)
        arms = rim[:, :1] * ahead[:, None] + rim[:, 1:] * aside[:, None]
        at = around.sample(grids, (band[:, None] + arms).reshape(-1, 2)).reshape(*arms.shape[:2], 3)
        lack = np.clip(1.0 - at[..., 0] / ROOM, 0.0, 1.0)
        force = (ease * PUSH) * (lack * lack)[..., None] * at[..., 1:]
        step = _moved(force.sum(axis=1), _turned(arms, force).sum(axis=1), aside)
        pushed = band + np.clip(step, -0.5 * STEP, 0.5 * STEP)
        band[first:-1] = cho_solve_banded(factor, pushed[first:-1] - bound @ band)
    return _fitted(around, footprint, band, first)


def _fitted(around: DistanceField, footprint: Footprint, band: Array, first: int) -> Array:
    """Second relaxation: centre the hull between obstacles that are too near for the resolution of the distance field.

    Args:
        around: Obstacles around the path.
        footprint: Hull of the robot.
        band: Path after the first relaxation [m], shape (k, 2); changed in place.
        first: Index of the first point that may move.
    """
    from scipy.linalg import cho_solve_banded

    factor, bound = _stiff(len(band), first, SUPPLE)
    for _ in range(FITTED):
        near = first + np.flatnonzero(around.sample(around.distance, band[first:-1]) < footprint.outer + FIT)
        if len(near) == 0:
            break
        low, high = band[near].min(axis=0) - footprint.outer - FIT, band[near].max(axis=0) + footprint.outer + FIT
        obstacles = around.points[((around.points > low) & (around.points < high)).all(axis=1)]
        if len(obstacles) == 0:  # the interpolated distances are smaller than the exact ones
            break
        heading = headings(band)
        ahead = np.column_stack([np.cos(heading), np.sin(heading)])
        aside = ahead[:, ::-1] * (-1.0, 1.0)
        force, turn = np.zeros_like(band), np.zeros(len(band))
        ahead_push, aside_push, turn[near] = _pushed(footprint, band[near], ahead[near], obstacles)
        force[near] = ahead_push[:, None] * ahead[near] + aside_push[:, None] * aside[near]
        step = np.clip(_moved(force, turn, aside), -FIT_PUSH, FIT_PUSH)
        band[first:-1] = cho_solve_banded(factor, (band + step)[first:-1] - bound @ band)
    return band


def _pushed(footprint: Footprint, points: Array, ahead: Array, obstacles: Array) -> tuple[Array, Array, Array]:
    """Pushes of obstacles on the hull at k points of the band.

    Args:
        footprint: Hull of the robot.
        points: Points of the band, world frame, shape (k, 2) [m].
        ahead: Unit vectors along the band at the points, shape (k, 2).
        obstacles: Positions of obstacles, world frame, shape (m, 2) [m].

    Returns:
        Push forward [m], push to the left [m], and torque [m2], each of shape (k,).
    """
    half_x, half_y = 0.5 * footprint.length, 0.5 * footprint.width
    dx, dy = (obstacles[:, axis] - points[:, axis, None] for axis in (0, 1))
    x, y = dx * ahead[:, :1] + dy * ahead[:, 1:], dy * ahead[:, :1] - dx * ahead[:, 1:]
    arm_x, arm_y = np.clip(x, -half_x, half_x), np.clip(y, -half_y, half_y)
    out_x, out_y = x - arm_x, y - arm_y  # vector from the hull; from inside, it points to the nearest side
    away = np.hypot(out_x, out_y)
    over_x, over_y = np.abs(x) - half_x, np.abs(y) - half_y
    over = np.maximum(over_x, over_y)
    gap, inside = away + np.minimum(over, 0.0), np.nonzero(over < 0.0)
    out_x[inside] = (over_x[inside] == over[inside]) * np.sign(x[inside])
    out_y[inside] = (over_y[inside] == over[inside]) * np.sign(y[inside])
    away[inside] = np.hypot(out_x[inside], out_y[inside])
    least = gap.min(axis=1)
    weight = np.exp(-(gap - least[:, None]) / SHARP)
    weight *= (FIT_PUSH * np.clip(1.0 - least / FIT, 0.0, 2.0) / weight.sum(axis=1))[:, None]
    away = np.maximum(away, 1e-9)
    x, y = -weight * (out_x / away), -weight * (out_y / away)
    turn = (arm_x * y - arm_y * x).sum(axis=1)
    return np.asfortranarray(x).sum(axis=1), np.asfortranarray(y).sum(axis=1), turn  # summed obstacle by obstacle


def _turned(arms: Array, forces: Array) -> Array:
    torque: Array = arms[..., 0] * forces[..., 1] - arms[..., 1] * forces[..., 0]
    return torque


def _moved(force: Array, turn: Array, aside: Array) -> Array:
    """Displacements of the band's points that the forces and torques on the hull cause, shape (k, 2) [m].

    A torque turns the hull by moving the two neighbouring points, because the chord between these defines the heading.
    """
    step, turning = force.copy(), turn[:, None] * aside / (2.0 * STEP)
    step[1:] += turning[:-1]
    step[:-1] -= turning[1:]
    return step


@lru_cache(maxsize=512)
def _stiff(count: int, first: int, stiff: float) -> tuple[tuple[Array, bool], Array]:
    """Bending matrix I + stiff D'D of a band with fixed first points and a fixed last point.

    Returns:
        Cholesky factor of the part of the matrix for the free points; and the part that couples free points to fixed
        ones.
    """
    from scipy.linalg import cholesky_banded
    from scipy.sparse import diags_array

    # Sparse, because a dense product of this size wakes all BLAS threads, which costs far more than the product.
    second = diags_array([1.0, -2.0, 1.0], offsets=[0, 1, 2], shape=(count - 2, count))
    bending = stiff * (second.T @ second).toarray()
    free = bending[first:-1, first:-1] + np.eye(count - first - 1)
    bands = np.zeros((3, len(free)))
    for k in range(min(3, len(free))):
        bands[2 - k, k:] = np.diagonal(free, k)
    bound = bending[first:-1].copy()
    bound[:, first:-1] = 0.0
    return (cholesky_banded(bands), False), bound


def _rim(footprint: Footprint) -> Array:
    """Points on the hull's outline, body frame, shape (RIM, 2) [m]."""
    x, y = 0.5 * footprint.length, 0.5 * footprint.width
    corners = np.array([(x, y), (-x, y), (-x, -y), (x, -y), (x, y)])
    stations = np.array([0.0, 2.0 * x, 2.0 * (x + y), 4.0 * x + 2.0 * y, 4.0 * (x + y)])
    at = np.arange(RIM) * stations[-1] / RIM
    return np.column_stack([np.interp(at, stations, corners[:, 0]), np.interp(at, stations, corners[:, 1])])
