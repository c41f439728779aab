"""How near a hull is to everything else."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .body import FLOOR, RobotBody, collides, geom_labels

Array = npt.NDArray[np.float64]

FEW = 8
"""So many distances are sooner measured than sifted."""

Among = Literal["all", "obstacles", "robots"]
"""What a hull may be near to: other robots, what is no robot, or both."""


class Nearness:
    """Distances between hulls and things; the floor is none.

    Args:
        model: The compiled model.
        robots: What belongs to which robot.
    """

    def __init__(self, model: Any, robots: Mapping[str, RobotBody]) -> None:
        import mujoco

        self._distance = mujoco.mj_geomDistance
        self._model = model
        self._names = geom_labels(model, robots)
        solid = [g for g in range(model.ngeom) if collides(model, g) and self._names[g] != FLOOR]
        hulls = [g for body in robots.values() for g in body.hull]
        others = [g for g in solid if self._names[g] not in robots]
        self._still = _Boxes(model, [g for g in others if int(model.geom_bodyid[g]) == 0])
        peers = {name: [g for g in hulls if g not in body.hull] for name, body in robots.items()}
        among = {"obstacles": dict.fromkeys(robots, others), "robots": peers}
        among["all"] = {name: [*others, *peers[name]] for name in robots}
        self._among = {of: {name: np.array(g, dtype=np.intp) for name, g in by.items()} for of, by in among.items()}
        self._bounds = np.where(model.geom_rbound > 0.0, model.geom_rbound, np.inf)  # 0: it has no end

    def clearance(self, data: Any, body: RobotBody, limit: float, among: Among = "all") -> tuple[float, str]:
        """The distance [m] from a hull to the nearest of some, and its name; (limit, "") when none is nearer."""
        best, name, others = limit, "", self._among[among][body.name]
        for hull in body.hull:
            for geom in self._candidates(data, hull, others):
                # mj_geomDistance cuts off at its limit, which must be finite and positive; it rejects what is farther
                # by its bounding sphere, in half a microsecond.
                found = self._distance(self._model, data, hull, geom, max(min(best, 1e3), 1e-6), None)
                if found < best:
                    best, name = float(found), self._names[geom]
        return best, name

    def _candidates(self, data: Any, hull: int, things: npt.NDArray[np.intp]) -> list[int]:
        """Those of some geoms that may be the nearest to a hull, in their order: a field of posts has few.

        Between the surfaces it is no farther than between the centres, and no nearer than between bounding spheres.
        """
        if len(things) <= FEW:
            few: list[int] = things.tolist()
            return few
        apart = data.geom_xpos[things] - data.geom_xpos[hull]
        centres = np.sqrt(np.einsum("ij,ij->i", apart, apart))
        spheres = centres - self._bounds[things] - self._bounds[hull]
        possible: list[int] = things[spheres <= centres.min()].tolist()
        return possible

    def room(self, data: Any, point: Array) -> float:
        """The distance of a point (3,) [m] from the nearest thing that cannot move [m]; exact for boxes."""
        return float(self._still.distances(data, point).min(initial=math.inf))


class _Boxes:
    """The boxes around geoms, each in its geom's own frame; planes have none."""

    def __init__(self, model: Any, geoms: list[int]) -> None:
        self._index = np.array(geoms, dtype=np.intp)
        self._centre = model.geom_aabb[self._index, :3].reshape(-1, 3).copy()
        self._half = model.geom_aabb[self._index, 3:].reshape(-1, 3).copy()

    def distances(self, data: Any, point: Array) -> Array:
        """(k,) Distances of a point (3,) from the boxes [m]; zero inside."""
        offset = (point - data.geom_xpos[self._index])[:, None, :]
        frames = data.geom_xmat[self._index].reshape(-1, 3, 3)
        local = (offset @ frames)[:, 0, :] - self._centre
        outside = np.maximum(np.abs(local) - self._half, 0.0)
        distances: Array = np.sqrt((outside * outside).sum(axis=1))
        return distances
