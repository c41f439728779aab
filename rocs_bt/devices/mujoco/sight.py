"""Check of lines of sight between robots."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from .body import RobotElements, collides

_ON = 1e-4  # [m] distance behind an ignored surface at which the ray continues
_OWN = 8  # maximum number of ignored surfaces along a ray

Point = tuple[float, float, float]


class LineOfSight:
    """Check of lines of sight between robots, which only geoms that can collide block."""

    def __init__(self, model: Any, robots: Mapping[str, RobotElements]) -> None:
        from .library import mujoco

        self._ray = mujoco.mj_ray
        self._model = model
        # MuJoCo takes arrays; for three numbers plain Python, by views of them, is faster than numpy.
        self._start, self._along, self._geom = np.zeros(3), np.zeros(3), np.zeros((1, 1), dtype=np.int32)
        self._from = cast("memoryview[float]", self._start.data)
        self._to = cast("memoryview[float]", self._along.data)
        self._hit = self._geom.data
        owned = {geom: body.name for body in robots.values() for geom in body.geoms}
        self._owners = [owned.get(geom, "") for geom in range(model.ngeom)]
        self._solid = [collides(model, geom) for geom in range(model.ngeom)]

    def clear(self, data: Any, robot: RobotElements, other: RobotElements, begin: Point, end: Point) -> bool:
        """Whether a ray between two points is not blocked by anything but the two robots at its ends.

        Args:
            data: MjData of the world, with updated poses.
            robot: Robot at the start of the ray.
            other: Robot at the end of the ray.
            begin: Start point of the ray, world frame [m].
            end: End point of the ray, world frame [m].
        """
        left = math.dist(begin, end)
        if left < _ON:
            return True
        (x, y, z), start, along = begin, self._from, self._to
        dx, dy, dz = [(b - a) / left for a, b in zip(begin, end, strict=True)]
        along[0], along[1], along[2] = dx, dy, dz
        for _ in range(_OWN):
            start[0], start[1], start[2] = x, y, z
            hit = self._ray(self._model, data, self._start, self._along, None, True, robot.root, self._geom)
            if hit < 0.0 or hit >= left:
                return True
            geom = self._hit[0, 0]
            if self._owners[geom] == other.name:
                return True
            if self._solid[geom] and self._owners[geom] != robot.name:
                return False
            on = hit + _ON
            x, y, z, left = x + on * dx, y + on * dy, z + on * dz, left - hit - _ON
        return False
