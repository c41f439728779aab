"""Static obstacles: posts and blocks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

Point = tuple[float, float]


@dataclass(frozen=True)
class Post:
    """An upright cylinder: name, centre x and y, radius, height [m]; without `solid`, nothing touches or sees it."""

    name: str
    x: float
    y: float
    radius: float
    height: float = 1.0
    solid: bool = True


@dataclass(frozen=True)
class Block:
    """An upright box: name, centre x and y, length and width [m], yaw [rad], height [m]."""

    name: str
    x: float
    y: float
    length: float
    width: float
    yaw: float = 0.0
    height: float = 1.0


def walls_around(low: Point, high: Point, *, thickness: float = 0.1, height: float = 1.0) -> list[Post | Block]:
    """Four walls centred on the edges of a rectangle; thickness and height in [m]."""
    (x0, y0), (x1, y1) = low, high
    x, y, wide, deep = (x0 + x1) / 2.0, (y0 + y1) / 2.0, x1 - x0 + thickness, y1 - y0 + thickness
    return [
        Block("wall_south", x, y0, wide, thickness, 0.0, height),
        Block("wall_north", x, y1, wide, thickness, 0.0, height),
        Block("wall_west", x0, y, thickness, deep, 0.0, height),
        Block("wall_east", x1, y, thickness, deep, 0.0, height),
    ]


def length_of(points: Sequence[Point]) -> float:
    """Length of a polyline [m]."""
    return sum(math.dist(a, b) for a, b in pairwise(points))
