"""Ground that is not level: height fields and boxes that belong to the floor."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...geometry import Pose2
from .body import GROUND, RobotBody

_BASE = 0.1  # [m] depth of a height field below the floor
_ABOVE = 100.0  # [m] height from which rays measure the ground
_POINTS = 9  # number of measured points along each side of the square around a robot
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
    heights: npt.NDArray[np.float64]


def add_ground(spec: Any, pieces: Iterable[GroundPiece]) -> None:
    """Add ground to the MjSpec of an arena, with the contact properties of its geom `floor`.

    Ground is part of the floor: contacts with it are no collisions, and clearances ignore it.
    """
    import mujoco

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
    """Height of the ground over the floor at a point or below a robot.

    Args:
        model: Compiled model.
        data: MjData of the world with the poses of all geoms.
    """

    def __init__(self, model: Any, data: Any) -> None:
        import mujoco

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

    def below(self, body: RobotBody, pose: Pose2) -> float:
        """Height of the highest measured point below a robot [m].

        Args:
            body: The robot.
            pose: Pose of the robot's base, world frame.
        """
        if not self:
            return 0.0
        steps = np.linspace(-body.reach, body.reach, _POINTS).tolist()
        return max(self.at(*pose.transform(x, y)) for x in steps for y in steps)

    def _top(self, geom: int, point: npt.NDArray[np.float64], down: npt.NDArray[np.float64]) -> float:
        model, data, kind = self._model, self._data, int(self._model.geom_type[geom])
        if kind == self._field:
            found = self._mj.mj_rayHfield(model, data, geom, point, down)
        else:
            frame = data.geom_xpos[geom], data.geom_xmat[geom]
            found = self._mj.mju_rayGeom(*frame, model.geom_size[geom], point, down, kind)
        return max(_ABOVE - found, 0.0) if found >= 0.0 else 0.0
