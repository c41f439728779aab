"""Rectangular floor with obstacles, exported as an MJCF world or as an occupancy grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from .floor_grid import FloorGrid
from .obstacle import Block, Point, Post


@dataclass
class Floor:
    """Rectangular floor with obstacles.

    Attributes:
        low, high: Corners of the floor with the smallest and with the largest coordinates, world frame [m].
        obstacles: Static obstacles.
        actors: Objects that the scenario moves, at their initial positions. The world contains them, the occupancy grid
            does not.
        mjcf: Additional MJCF elements of the world body, which the occupancy grid does not contain.
    """

    low: Point
    high: Point
    obstacles: list[Post | Block] = field(default_factory=list)
    actors: list[Post | Block] = field(default_factory=list)
    mjcf: str = ""

    def world(self, name: str, doc: str) -> str:
        """Text of the world file, MJCF."""
        (x0, y0), (x1, y1) = self.low, self.high
        centre = f"{_n((x0 + x1) / 2)} {_n((y0 + y1) / 2)}"
        lines = [
            f"<!-- {doc} -->",
            f'<mujoco model="{name}">',
            "  <visual>",
            '    <global offwidth="1280" offheight="960"/>',
            '    <headlight ambient=".4 .4 .4" diffuse=".5 .5 .5"/>',
            "  </visual>",
            "  <worldbody>",
            f'    <geom name="floor" type="plane" size="{_n((x1 - x0) / 2)} {_n((y1 - y0) / 2)} 0.1" pos="{centre} 0" '
            'rgba=".9 .9 .87 1"/>',
            *(f"    {_geom(obstacle, obstacle.x, obstacle.y)}" for obstacle in self.obstacles),
        ]
        for actor in self.actors:
            lines.append(f'    <body name="{actor.name}" mocap="true" pos="{_n(actor.x)} {_n(actor.y)} 0">')
            lines += [f"      {_geom(actor, 0.0, 0.0)}", "    </body>"]
        more = [self.mjcf] if self.mjcf else []
        return "\n".join([*lines, *more, "  </worldbody>", "</mujoco>", ""])

    def grid(self, cell: float) -> FloorGrid:
        """Occupancy grid with a cell size [m]: a cell is occupied if its centre is inside an obstacle."""
        (x0, y0), (x1, y1) = self.low, self.high
        shape = max(math.ceil((y1 - y0) / cell - 1e-9), 1), max(math.ceil((x1 - x0) / cell - 1e-9), 1)
        grid = FloorGrid(np.zeros(shape, dtype=np.bool_), cell, self.low)
        for obstacle in self.obstacles:
            grid.add(obstacle)
        return grid

    def clearance(self, points: Sequence[Point]) -> float:
        """Minimum distance from a polyline to the surface of any post [m]; +inf without posts."""
        discs = np.array([(p.x, p.y, p.radius) for p in self.obstacles if isinstance(p, Post)]).reshape(-1, 3)
        corners = np.array(points)
        begin, along = corners[:-1, None, :], np.diff(corners, axis=0)[:, None, :]
        away = discs[None, :, :2] - begin
        squared = np.maximum((along * along).sum(axis=2), 1e-18)
        share = np.clip((away * along).sum(axis=2) / squared, 0.0, 1.0)
        gap = away - share[:, :, None] * along
        return float((np.sqrt((gap * gap).sum(axis=2)) - discs[:, 2]).min(initial=math.inf))


def _geom(obstacle: Post | Block, x: float, y: float) -> str:
    attributes = f'name="{obstacle.name}" pos="{_n(x)} {_n(y)} {_n(obstacle.height / 2)}"'
    if isinstance(obstacle, Post):
        size = f"{_n(obstacle.radius)} {_n(obstacle.height / 2)}"
        looks = 'rgba=".55 .5 .45 1"' if obstacle.solid else 'rgba="0 0 0 0" contype="0" conaffinity="0"'
        return f'<geom type="cylinder" size="{size}" {attributes} {looks}/>'
    size = f"{_n(obstacle.length / 2)} {_n(obstacle.width / 2)} {_n(obstacle.height / 2)}"
    turn = f' euler="0 0 {_n(math.degrees(obstacle.yaw))}"' if obstacle.yaw else ""
    return f'<geom type="box" size="{size}" {attributes}{turn} rgba=".55 .58 .62 1"/>'


def _n(number: float) -> str:
    return f"{number:.6g}"
