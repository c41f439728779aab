"""The arena of EXP1 in the plane: walls, the box, another robot as a disc, and the outline of a Pioneer P3-DX."""

from __future__ import annotations

import math

import numpy as np

WALLS = [(2.5, 0.0, 0.025, 2.5), (-2.475, 0.0, 0.025, 2.5), (0.0, 2.5, 2.5, 0.025), (0.0, -2.45, 2.5, 0.025)]
BOX = (-0.5, 1.0, 0.25, 0.25)  # centre x, y and half sizes [m], as those of the walls
LEFT = [(0.183, 0.03), (0.163, 0.087), (0.0975, 0.1905), (-0.0975, 0.1905), (-0.214, 0.132), (-0.272, 0.03)]
HULL = np.array([*LEFT, *((x, -y) for x, y in reversed(LEFT))])  # [m], anticlockwise, in the frame of the robot


class Arena:
    """Obstacles in the world frame.

    Attributes:
        corners: Corners of the boxes [m], shape (4 n, 2).
        low: Lower corners of the boxes [m], shape (n, 2).
        high: Upper corners of the boxes [m], shape (n, 2).
    """

    def __init__(self) -> None:
        boxes = np.array([*WALLS, BOX])
        self.low, self.high = boxes[:, :2] - boxes[:, 2:], boxes[:, :2] + boxes[:, 2:]
        self.corners = np.concatenate([boxes[:, :2] + boxes[:, 2:] * (x, y) for x in (-1, 1) for y in (-1, 1)])

    def ranges(self, x: float, y: float, angles: np.ndarray, disc: tuple[float, float, float] | None) -> np.ndarray:
        """Distances from a point to the first obstacle along each direction [m]; inf without one.

        Args:
            x: Position of the point [m].
            y: Position of the point [m].
            angles: Directions in the world frame [rad], shape (n,).
            disc: Centre and radius of a disc [m], or None.
        """
        origin, directions = np.array([x, y]), np.stack([np.cos(angles), np.sin(angles)], axis=1)[:, None, :]
        directions[np.abs(directions) < 1e-12] = 1e-12
        to_low, to_high = (self.low - origin) / directions, (self.high - origin) / directions
        enter, leave = np.minimum(to_low, to_high).max(axis=2), np.maximum(to_low, to_high).min(axis=2)
        found = np.where(leave >= np.maximum(enter, 0.0), np.maximum(enter, 0.0), math.inf).min(axis=1)
        return found if disc is None else np.minimum(found, _to_disc(origin, directions[:, 0], disc))

    def clearance(self, x: float, y: float, yaw: float, disc: tuple[float, float, float] | None) -> float:
        """Distance between the outline of the robot and the nearest obstacle [m]; zero if they overlap."""
        turn = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
        hull = HULL @ turn + (x, y)
        beside = np.maximum(np.maximum(self.low - hull[:, None], hull[:, None] - self.high), 0.0)
        found = min(float(np.hypot(*np.moveaxis(beside, 2, 0)).min()), _to_polygon(self.corners, hull))
        return found if disc is None else min(found, max(_to_polygon(np.array([disc[:2]]), hull) - disc[2], 0.0))


def _to_disc(origin: np.ndarray, directions: np.ndarray, disc: tuple[float, float, float]) -> np.ndarray:
    """Distances to a disc along each direction [m]; inf where the ray passes it."""
    centre = np.array(disc[:2]) - origin
    along = directions @ centre
    inside = disc[2] ** 2 - (centre @ centre - along**2)
    first = along - np.sqrt(np.maximum(inside, 0.0))
    return np.where((inside >= 0.0) & (along > 0.0), np.maximum(first, 0.0), math.inf)


def _to_polygon(points: np.ndarray, polygon: np.ndarray) -> float:
    """Distance between the nearest of some points and a convex, anticlockwise polygon [m]; zero inside."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    offsets = points[:, None, :] - polygon
    if (edges[:, 0] * offsets[..., 1] - edges[:, 1] * offsets[..., 0] >= 0.0).all(axis=1).any():
        return 0.0
    shares = np.clip((offsets * edges).sum(axis=2) / (edges**2).sum(axis=1), 0.0, 1.0)
    return float(np.hypot(*np.moveaxis(offsets - shares[..., None] * edges, 2, 0)).min())
