"""Ray casting in MuJoCo, which casts all rays of a scan in one call and is fast even with many geoms."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from .state import WorldState

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

TILE = 1.75
"""Side length of a tile of the floor [m]; see `Rays`."""

MANY = 64
"""Minimum number of geoms of a world for which ray casting with tiles is faster."""


class Scan:
    """Rays of a laser scanner from one site, cast at the same time or in a sweep; arguments as of `Scene.scan`.

    They ignore the body that carries the scanner, and echoes of other parts of the robot are removed.
    """

    def __init__(
        self, world: WorldState, robot: str, site: str, bearings: Sequence[float], reach: float, sweep: float
    ) -> None:
        model = world.model
        self._world, self._reach, self._sweep = world, reach, sweep
        self._site = model.site(f"{robot}/{site}").id
        angles = np.array(bearings)
        self._rays = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
        self._cast = Rays(model, int(model.site_bodyid[self._site]))
        world.remember(sweep)

    def __call__(self) -> Array:
        """Distances along the rays [m], +inf without a hit, shape (rays,): in the present state, or during a sweep."""
        world, sweep = self._world, self._sweep
        if not sweep:
            world.update_poses()
            return self._look(world.data, self._rays)
        steps = max(round(sweep / world.step), 1)  # the world is the same for all rays of a physics step
        of_ray = np.rint(np.linspace(-steps, 0.0, len(self._rays))).astype(int)
        looks = [(step, self._rays[of_ray == step]) for step in range(-steps, 1)]
        return np.concatenate([self._look(world.past(world.stamp + s * world.step), rays) for s, rays in looks])

    def _look(self, data: Any, rays: Array) -> Array:
        """Distances along some rays, sensor frame, in one state with updated poses."""
        directions = rays @ data.site_xmat[self._site].reshape(3, 3).T
        distances = self._cast.distances(data, data.site_xpos[self._site], directions, self._reach)
        found: Array = np.where(distances < 0.0, math.inf, distances)
        return found


class Rays:
    """Ray caster for rays with a common origin.

    MuJoCo tests each ray against a bounding sphere per body, then against all geoms of that body one by one. All static
    geoms belong to one body, so this is slow with many geoms. Rays are then cast in a second model, in which the static
    geoms of each square tile of the floor belong to a body of their own. The geoms are the same, so the distances are
    bit-identical.

    Rays that end at another part of the robot that carries the scanner have no hit, as drivers of real scanners remove
    echoes of the robot by its joint angles.

    Args:
        model: Compiled MjModel.
        excluded: ID of the body that carries the scanner, which the rays ignore.
    """

    def __init__(self, model: Any, excluded: int) -> None:
        from .library import mujoco

        self._cast = mujoco.mj_multiRay
        self._model, self._excluded = model, excluded
        own = np.flatnonzero(model.body_rootid == model.body_rootid[excluded])
        # Before MuJoCo 4.0, rays miss some geoms in a model with tiles.
        tiles_are_right = mujoco.mj_version() >= 4_000_000
        self._tiled = _tiled(model) if tiles_are_right and model.ngeom >= MANY else None
        if self._tiled is not None:
            self._model = self._tiled.model
            self._excluded = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_BODY, str(excluded))
            here, there = self._tiled.bodies
            own = here[np.isin(there, own)]
            self._copy = mujoco.MjData(self._model)
            mujoco.mj_kinematics(self._model, self._copy)
        self._own = np.append(np.isin(self._model.geom_bodyid, own), False)  # by geom; the last is for no hit, -1

    def distances(self, data: Any, origin: Array, directions: Array, cutoff: float) -> Array:
        """Cast rays; returns the distances to the first hits.

        Args:
            data: MjData of the world, with updated poses.
            origin: Common origin of the rays [m], world frame, shape (3,).
            directions: Unit vectors of the rays, world frame, shape (k, 3).
            cutoff: Distance beyond which hits may be ignored [m].

        Returns:
            Distances [m], -1 without a hit, shape (k,).
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
        found[self._own[hit]] = -1.0
        return found


@dataclass(frozen=True, eq=False)
class _Tiled:
    """Copy of a model for fast ray casting, in which the static geoms are grouped into tiles of the floor."""

    model: Any
    bodies: tuple[Indices, Indices]  # movable bodies: indices here, and in the original model
    geoms: tuple[Indices, Indices]  # movable geoms: indices here, and in the original model

    def follow(self, copy: Any, data: Any) -> None:
        """Copy the poses of all movable bodies and geoms from the world."""
        (bodies, world_bodies), (geoms, world_geoms) = self.bodies, self.geoms
        copy.xipos[bodies] = data.xipos[world_bodies]
        copy.geom_xpos[geoms], copy.geom_xmat[geoms] = data.geom_xpos[world_geoms], data.geom_xmat[world_geoms]


@lru_cache(maxsize=4)
def _tiled(model: Any) -> _Tiled | None:
    """Create a copy of a model with tiles; None if the model has other geoms than primitive shapes."""
    from .library import mujoco

    kinds = mujoco.mjtGeom
    plain = {"SPHERE", "CAPSULE", "ELLIPSOID", "CYLINDER", "BOX", "PLANE"}
    if not plain.issuperset(kinds(kind).name.removeprefix("mjGEOM_") for kind in set(model.geom_type.tolist())):
        return None
    spec, parents = mujoco.MjSpec(), dict[Any, Any]()
    bodies, kind, size = model.geom_bodyid.tolist(), model.geom_type.tolist(), model.geom_size.tolist()
    position, turn = model.geom_pos.tolist(), model.geom_quat.tolist()
    shown = [geom for geom in range(model.ngeom) if _is_shown(model, geom)]
    for geom in shown:
        if bodies[geom] == 0 and kind[geom] == kinds.mjGEOM_PLANE:
            parent = spec.worldbody  # planes belong to no tile
        else:
            key = bodies[geom] or (position[geom][0] // TILE, position[geom][1] // TILE)
            parent = parents.get(key) or parents.setdefault(key, _body(spec, model, bodies[geom]))
        parent.add_geom(type=kinds(kind[geom]), size=size[geom], pos=position[geom], quat=turn[geom])
    compiled = spec.compile()
    names = ((i, compiled.body(i).name) for i in range(compiled.nbody))
    moving = {i: int(name) for i, name in names if name.isdecimal()}
    here = [geom for geom, body in enumerate(compiled.geom_bodyid.tolist()) if body in moving]
    there = [geom for body in moving.values() for geom in shown if bodies[geom] == body]  # in the same order
    return _Tiled(compiled, _indices(moving.items()), _indices(zip(here, there, strict=True)))


def _is_shown(model: Any, geom: int) -> bool:
    """Whether rays hit a geom: they do not hit fully transparent geoms."""
    material = model.geom_matid[geom]
    return bool((model.geom_rgba[geom, 3] if material < 0 else model.mat_rgba[material, 3]) != 0.0)


def _body(spec: Any, model: Any, body: int) -> Any:
    """Add a body to the copy of a model: a tile (body 0), or the counterpart of a movable body.

    A counterpart has the inertia of the original body, because MuJoCo centres the body's bounding sphere on it.
    """
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


def _indices(pairs: Iterable[tuple[int, int]]) -> tuple[Indices, Indices]:
    here, there = np.array(list(pairs), dtype=np.intp).reshape(-1, 2).T
    return here, there
