"""Ground that is not level: height fields and boxes that belong to the floor."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...base.geometry import Pose2
from .body import GROUND, box_points, collides

Array = npt.NDArray[np.float64]

_BASE = 0.1  # [m] depth of a height field below the floor
_ABOVE = 100.0  # [m] height from which rays measure the ground
_POINTS = 9  # number of measured points along each side of the rectangle below a robot or an object
_INSIDE = 1e-6  # [m] distance of measured points from the border of the ground
_LIKE_FLOOR = ("friction", "condim", "priority", "solref", "solimp")  # taken from the geom `floor`
_COLOUR = (0.55, 0.5, 0.42, 1.0)


@dataclass(frozen=True, eq=False)
class GroundPiece:
    """Rectangle of ground above the floor.

    Attributes:
        name: Name of the piece.
        pose: Centre of the rectangle, world frame; the length is along its x axis.
        length, width: Size of the rectangle [m].
        heights: Heights over the floor at equal distances along length and width [m], shape (width, length); a single
            height is a box.
    """

    name: str
    pose: Pose2
    length: float
    width: float
    heights: Array


def add_ground(spec: Any, pieces: Iterable[GroundPiece]) -> None:
    """Add ground to the MjSpec of an arena, with the contact properties of its geom `floor`.

    Ground is part of the floor: clearances ignore it, and only contacts of hulls with its side faces are collisions.
    """
    from .library import mujoco

    floor = spec.geom("floor")
    for piece in pieces:
        x, y, yaw = piece.pose
        name, half = f"{GROUND}{piece.name}", (piece.length / 2.0, piece.width / 2.0)
        top = float(piece.heights.max())
        geom = spec.worldbody.add_geom(name=name, quat=(np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0)), rgba=_COLOUR)
        if piece.heights.size == 1:
            geom.type, geom.size, geom.pos = mujoco.mjtGeom.mjGEOM_BOX, (*half, top / 2.0), (x, y, top / 2.0)
        else:
            rows, columns = piece.heights.shape
            size, data = (*half, top, _BASE), piece.heights.ravel().tolist()
            spec.add_hfield(name=name, nrow=rows, ncol=columns, size=size, userdata=data)
            geom.type, geom.hfieldname, geom.pos = mujoco.mjtGeom.mjGEOM_HFIELD, name, (x, y, 0.0)
        for key in _LIKE_FLOOR if floor is not None else ():
            setattr(geom, key, getattr(floor, key))


class GroundHeight:
    """Height of the ground over the floor at a point, or below a robot or an object."""

    def __init__(self, model: Any, data: Any) -> None:
        from .library import mujoco

        self._mj, self._model, self._data = mujoco, model, data
        self._geoms = [g for g in range(model.ngeom) if model.geom(g).name.startswith(GROUND)]
        self._field = int(mujoco.mjtGeom.mjGEOM_HFIELD)

    def __bool__(self) -> bool:
        """Whether the world has such ground."""
        return bool(self._geoms)

    def at(self, x: float, y: float) -> float:
        """Height of the ground at a point of the world frame [m]; 0 on the level floor."""
        point, down = np.array([x, y, _ABOVE]), np.array([0.0, 0.0, -1.0])
        return max((self._top(geom, point, down) for geom in self._geoms), default=0.0)

    def below(self, pose: Pose2, reach: float) -> float:
        """Height of the highest point of the ground in a square [m].

        Args:
            pose: Centre and direction of the square, world frame.
            reach: Half the length of its sides [m].
        """
        c, s = reach * math.cos(pose.yaw), reach * math.sin(pose.yaw)
        return self._highest(np.array([pose.x - c + s, pose.y - s - c]), 2.0 * np.array([(c, s), (-s, c)]))

    def below_geoms(self, geoms: Iterable[int], yaw: float) -> float:
        """Height of the highest point of the ground in the rectangle around geoms [m].

        Args:
            geoms: IDs of the geoms; `data` has their poses. Geoms that do not collide are ignored.
            yaw: Direction of the rectangle, world frame [rad].
        """
        model, data, c, s = self._model, self._data, math.cos(yaw), math.sin(yaw)
        boxes = [
            (box_points(model, g) @ data.geom_xmat[g].reshape(3, 3).T + data.geom_xpos[g])[:, :2]
            for g in geoms
            if collides(model, g)
        ]
        axes = np.array([(c, s), (-s, c)])
        along = np.concatenate(boxes) @ axes.T
        low = along.min(axis=0)
        return self._highest(low @ axes, (along.max(axis=0) - low)[:, None] * axes)

    def _highest(self, corner: Array, sides: Array) -> float:
        """Height of the highest point of the ground in a rectangle [m].

        Corners of the common area, vertices of height fields in it, and a grid are measured. The result is exact for
        level ground and slopes.

        Args:
            corner: Corner of the rectangle, shape (2,), world frame [m].
            sides: Vectors from the corner along the two sides, shape (2, 2), world frame [m].
        """
        steps = np.linspace(0.0, 1.0, _POINTS)
        grid = np.array([(u, v) for u in steps for v in steps]) @ sides + corner
        outline = corner + np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]) @ sides
        best, down = 0.0, np.array([0.0, 0.0, -1.0])
        for geom in self._geoms:
            place, turn = self._data.geom_xpos[geom, :2], self._data.geom_xmat[geom].reshape(3, 3)[:2, :2]
            common = _clipped((outline - place) @ turn, self._model.geom_aabb[geom])
            if not len(common):
                continue
            for x, y in np.concatenate([common @ turn.T + place, grid]).tolist():
                best = max(best, self._top(geom, np.array([x, y, _ABOVE]), down))
            if int(self._model.geom_type[geom]) == self._field:
                points, heights = self._vertices(geom)
                shares = (points @ turn.T + place - corner) @ np.linalg.inv(sides)
                best = max(best, heights[((shares >= 0.0) & (shares <= 1.0)).all(axis=1)].max(initial=0.0))
        return best

    def _vertices(self, geom: int) -> tuple[Array, Array]:
        """Vertices of a height field: positions in the frame of the geom, shape (n, 2), and heights, shape (n,) [m]."""
        model, field = self._model, int(self._model.geom_dataid[geom])
        rows, columns, first = (int(of[field]) for of in (model.hfield_nrow, model.hfield_ncol, model.hfield_adr))
        x, y, top, _ = model.hfield_size[field].tolist()
        ys, xs = np.meshgrid(np.linspace(-y, y, rows), np.linspace(-x, x, columns), indexing="ij")
        heights: Array = top * model.hfield_data[first : first + rows * columns].astype(np.float64)
        return np.stack([xs.ravel(), ys.ravel()], axis=1), heights

    def _top(self, geom: int, point: Array, down: Array) -> float:
        model, data, kind = self._model, self._data, int(self._model.geom_type[geom])
        if kind == self._field:
            found = self._mj.mj_rayHfield(model, data, geom, point, down)
        else:
            frame = data.geom_xpos[geom], data.geom_xmat[geom]
            found = self._mj.mju_rayGeom(*frame, model.geom_size[geom], point, down, kind)
        return max(_ABOVE - found, 0.0) if found >= 0.0 else 0.0


def _clipped(outline: Array, box: Sequence[float]) -> Array:
    """Part of a convex polygon, shape (n, 2) [m], in a box: centre and half-sizes, shape (6,) (Sutherland-Hodgman)."""
    points = [*outline]
    for axis in (0, 1):
        for side in (-1.0, 1.0):
            limit, kept = side * box[axis] + box[axis + 3] - _INSIDE, []
            for one, two in zip(points, [*points[1:], *points[:1]], strict=True):
                here, there = limit - side * one[axis], limit - side * two[axis]
                if here >= 0.0:
                    kept.append(one)
                if here * there < 0.0:
                    kept.append(one + (two - one) * here / (here - there))
            points = kept
    return np.array(points).reshape(-1, 2)
