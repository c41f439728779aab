"""Rays: how far it is to what many rays from one place meet, quickly also where much stands around."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

TILE = 1.75
"""Side of a tile [m]."""

MANY = 64
"""From so many geoms on tiles are worth their while."""


class Rays:
    """Casts rays from one place at a time.

    MuJoCo holds each ray against a sphere around each body, and then against that body's geoms one by one; whatever
    stands in the world is one body's. Where much does, rays are cast in a second model, which has a body for each tile
    of the ground. Its geoms are the same, so the distances are too, to the bit.

    Args:
        model: The compiled MjModel.
        excluded: The body that rays pass through.
    """

    def __init__(self, model: Any, excluded: int) -> None:
        import mujoco

        self._cast = mujoco.mj_multiRay
        self._model, self._excluded = model, excluded
        # Before 4.0 rays miss some geoms of such tiles.
        tiles_are_right = mujoco.mj_version() >= 4_000_000
        self._tiled = _tiled(model) if tiles_are_right and model.ngeom >= MANY else None
        if self._tiled is not None:
            self._model = self._tiled.model
            self._excluded = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_BODY, str(excluded))
            self._copy = mujoco.MjData(self._model)
            mujoco.mj_kinematics(self._model, self._copy)

    def distances(self, data: Any, origin: Array, directions: Array, cutoff: float) -> Array:
        """(k,) How far it is along each ray [m]; -1 where there is nothing.

        Args:
            data: The world's MjData, its poses up to date.
            origin: (3,) Where all rays begin [m].
            directions: (k, 3) Where they go, of length 1.
            cutoff: What is farther away may be left out [m].
        """
        if self._tiled is not None:
            self._tiled.follow(self._copy, data)
            data = self._copy
        found, hit = np.empty(len(directions)), np.empty(len(directions), dtype=np.int32)
        self._cast(
            self._model,
            data,
            origin,
            directions.ravel(),
            None,
            True,
            self._excluded,
            hit,
            found,
            None,
            len(found),
            cutoff,
        )
        return found


@dataclass(frozen=True, eq=False)
class _Tiled:
    """A model for rays only.

    Attributes:
        model: The compiled MjModel.
        bodies: Its bodies that may move: their places here, and those in the first model.
        geoms: The same of its geoms that may move.
    """

    model: Any
    bodies: tuple[Places, Places]
    geoms: tuple[Places, Places]

    def follow(self, copy: Any, data: Any) -> None:
        """Let everything be where it is in the world."""
        (here, there), (shapes, those) = self.bodies, self.geoms
        copy.xipos[here] = data.xipos[there]
        copy.geom_xpos[shapes], copy.geom_xmat[shapes] = data.geom_xpos[those], data.geom_xmat[those]


@lru_cache(maxsize=4)
def _tiled(model: Any) -> _Tiled | None:
    """A model in tiles; None of one that has other than plain shapes."""
    import mujoco

    kinds = mujoco.mjtGeom
    plain = {"SPHERE", "CAPSULE", "ELLIPSOID", "CYLINDER", "BOX", "PLANE"}
    if not plain.issuperset(kinds(kind).name.removeprefix("mjGEOM_") for kind in set(model.geom_type.tolist())):
        return None
    spec, parents = mujoco.MjSpec(), dict[Any, Any]()
    bodies, kind, size = model.geom_bodyid.tolist(), model.geom_type.tolist(), model.geom_size.tolist()
    place, turn = model.geom_pos.tolist(), model.geom_quat.tolist()
    shown = [geom for geom in range(model.ngeom) if _is_shown(model, geom)]
    for geom in shown:
        if bodies[geom] == 0 and kind[geom] == kinds.mjGEOM_PLANE:
            parent = spec.worldbody  # it is in no tile
        else:
            key = bodies[geom] or (place[geom][0] // TILE, place[geom][1] // TILE)
            parent = parents.get(key) or parents.setdefault(key, _body(spec, model, bodies[geom]))
        parent.add_geom(type=kinds(kind[geom]), size=size[geom], pos=place[geom], quat=turn[geom])
    compiled = spec.compile()
    names = ((i, compiled.body(i).name) for i in range(compiled.nbody))
    moving = {i: int(name) for i, name in names if name.isdecimal()}
    here = [geom for geom, body in enumerate(compiled.geom_bodyid.tolist()) if body in moving]
    there = [geom for body in moving.values() for geom in shown if bodies[geom] == body]  # in the same order
    return _Tiled(compiled, _places(moving.items()), _places(zip(here, there, strict=True)))


def _is_shown(model: Any, geom: int) -> bool:
    """Whether rays meet it: what is wholly transparent they pass through."""
    material = model.geom_matid[geom]
    return bool((model.geom_rgba[geom, 3] if material < 0 else model.mat_rgba[material, 3]) != 0.0)


def _body(spec: Any, model: Any, body: int) -> Any:
    """A body of the same inertia, about whose middle MuJoCo puts its sphere, or a tile."""
    if body == 0:
        return spec.worldbody.add_body()
    return spec.worldbody.add_body(
        name=str(body),
        explicitinertial=True,
        mass=model.body_mass[body],
        inertia=model.body_inertia[body],
        ipos=model.body_ipos[body],
        iquat=model.body_iquat[body],
    )


def _places(pairs: Iterable[tuple[int, int]]) -> tuple[Places, Places]:
    here, there = np.array(list(pairs), dtype=np.intp).reshape(-1, 2).T
    return here, there
