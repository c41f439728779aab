"""Clearance of robot hulls and of points in a MuJoCo world."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .body import FLOOR, GROUND, RobotElements, collides, geom_labels

Array = npt.NDArray[np.float64]

FEW = 8
"""Maximum number of geoms for which measuring all distances is faster than a preselection."""

Among = Literal["all", "obstacles", "robots"]
"""Obstacles that count for the clearance of a hull: other robots, obstacles that are no robots, or all."""


_TOUCH = 1e-4
"""Gap [m] below which the nearest points of two bodies give no direction."""


@dataclass(frozen=True)
class Near:
    """Body near another one.

    Attributes:
        name: Name of the body.
        gap: Distance of the surfaces [m]; negative if they overlap.
        direction: Direction from the other one to this body at the nearest points, shape (2,), world frame.
        point: Nearest point of this body, shape (2,), world frame [m].
    """

    name: str
    gap: float
    direction: Array
    point: Array


class ClearanceQuery:
    """Distances between robot hulls and obstacles, without the floor."""

    def __init__(self, model: Any, robots: Mapping[str, RobotElements]) -> None:
        from .library import mujoco

        self._distance = mujoco.mj_geomDistance
        self._model = model
        self._names = geom_labels(model, robots)
        field = int(mujoco.mjtGeom.mjGEOM_HFIELD)
        self._floor = [
            g
            for g in range(model.ngeom)
            if self._names[g] == FLOOR
            and not model.geom(g).name.startswith(GROUND)
            and int(model.geom_type[g]) != field
        ]
        solid = [g for g in range(model.ngeom) if collides(model, g) and self._names[g] != FLOOR]
        hulls = [g for body in robots.values() for g in body.hull]
        others = [g for g in solid if self._names[g] not in robots]
        self._still = _Boxes(model, [g for g in others if int(model.geom_bodyid[g]) == 0])
        peers = {name: [g for g in hulls if g not in body.hull] for name, body in robots.items()}
        among = {"obstacles": dict.fromkeys(robots, others), "robots": peers}
        among["all"] = {name: [*others, *peers[name]] for name in robots}
        self._among = {of: {name: np.array(g, dtype=np.intp) for name, g in by.items()} for of, by in among.items()}
        self._bounds = np.where(model.geom_rbound > 0.0, model.geom_rbound, np.inf)  # 0 means infinite

    def clearance(self, data: Any, body: RobotElements, limit: float, among: Among = "all") -> tuple[float, str]:
        """Distance from a robot's hull to the nearest obstacle.

        Args:
            data: MjData of the world, with updated poses.
            body: Robot.
            limit: Distance beyond which obstacles are ignored [m].
            among: Obstacles that count.

        Returns:
            Distance [m], negative if they overlap, and name of the obstacle; (limit, "") if none is within the limit.
        """
        best, name, others = limit, "", self._among[among][body.name]
        for hull in body.hull:
            for geom in self._candidates(data, hull, others):
                # mj_geomDistance stops at its limit, which must be finite and positive; it rejects geoms with a farther
                # bounding sphere in half a microsecond.
                found = self._distance(self._model, data, hull, geom, max(min(best, 1e3), 1e-6), None)
                if found < best:
                    best, name = float(found), self._names[geom]
        return best, name

    def around(self, data: Any, geoms: Sequence[int], others: Mapping[str, Sequence[int]], limit: float) -> list[Near]:
        """Other bodies near a body.

        Args:
            data: MjData of the world, with updated poses.
            geoms: Geoms of the body.
            others: Geoms of the other bodies, by name.
            limit: Distance beyond which bodies are ignored [m].
        """
        found, ends = [], np.zeros(6)
        for name, theirs in others.items():
            best: Near | None = None
            for one in geoms:
                for two in theirs:
                    most = limit if best is None else max(best.gap, 1e-6)
                    gap = float(self._distance(self._model, data, one, two, most, ends))
                    if gap < most:
                        across = math.copysign(1.0, gap) * (ends[3:5] - ends[:2])
                        if abs(gap) < _TOUCH or not across.any():  # their nearest points are one but for rounding
                            across = ends[3:5] - data.geom_xpos[one][:2]
                        best = Near(name, gap, across / max(float(np.hypot(*across)), 1e-9), ends[3:5].copy())
            if best is not None:
                found.append(best)
        return found

    def sunk(self, data: Any, body: RobotElements) -> tuple[float, str, str]:
        """Greatest overlap of a robot's hull with the level floor.

        Returns:
            Depth [m], name of the geom of the hull, and name of the geom of the floor; (0, "", "") without an overlap.
        """
        model, found = self._model, (0.0, "", "")
        for hull in body.hull:
            for geom in self._floor:
                one, two = (model.geom_contype[g] for g in (hull, geom))
                if not (one & model.geom_conaffinity[geom] or two & model.geom_conaffinity[hull]):
                    continue
                depth = -float(self._distance(model, data, hull, geom, 1e-6, None))
                if depth > found[0]:
                    own = model.geom(hull).name.removeprefix(f"{body.name}/")
                    found = depth, own or f"geom {hull}", model.geom(geom).name or FLOOR
        return found

    def _candidates(self, data: Any, hull: int, geoms: npt.NDArray[np.intp]) -> list[int]:
        """Preselect the geoms that may be the nearest to a geom of a hull.

        The distance between two surfaces is at most that between the centres, and at least that between the bounding
        spheres.
        """
        if len(geoms) <= FEW:
            few: list[int] = geoms.tolist()
            return few
        apart = data.geom_xpos[geoms] - data.geom_xpos[hull]
        centres = np.sqrt(np.einsum("ij,ij->i", apart, apart))
        spheres = centres - self._bounds[geoms] - self._bounds[hull]
        possible: list[int] = geoms[spheres <= centres.min()].tolist()
        return possible

    def room(self, data: Any, point: Array) -> float:
        """Distance from a point, shape (3,), world frame [m], to the nearest static obstacle [m]; exact for boxes."""
        return float(self._still.distances(data, point).min(initial=math.inf))


class _Boxes:
    """Bounding boxes of geoms, each aligned with the frame of its geom."""

    def __init__(self, model: Any, geoms: list[int]) -> None:
        self._index = np.array(geoms, dtype=np.intp)
        self._centre = model.geom_aabb[self._index, :3].reshape(-1, 3).copy()
        self._half = model.geom_aabb[self._index, 3:].reshape(-1, 3).copy()

    def distances(self, data: Any, point: Array) -> Array:
        """Distances from a point, shape (3,), world frame [m], to the k boxes, shape (k,) [m]; 0 inside a box."""
        offset = (point - data.geom_xpos[self._index])[:, None, :]
        frames = data.geom_xmat[self._index].reshape(-1, 3, 3)
        local = (offset @ frames)[:, 0, :] - self._centre
        outside = np.maximum(np.abs(local) - self._half, 0.0)
        distances: Array = np.sqrt((outside * outside).sum(axis=1))
        return distances
