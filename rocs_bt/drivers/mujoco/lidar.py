"""Laser scanner in MuJoCo: all rays of a scan in one call, quick also in worlds with many geoms."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ...device import Reading
from ...errors import InputError, unknown
from ...record.header import Fan
from ..parameters import LidarParameters, read_parameters
from .mount import Mount
from .sensor import MujocoSensor

Array = npt.NDArray[np.float64]


class Lidar(MujocoSensor):
    """Ranges [m] along rays from one site, from the right to the left; a scan is taken at one instant.

    The rays lie in the plane of the site and pitch with the robot. They pass through the body that carries the scanner.
    """

    declares = LidarParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        self.parameters = _read(parameters, name)
        model = mount.world.model
        self._site = model.site(f"{mount.robot}/{self.parameters.site}").id
        bearings = np.array(self.parameters.bearings)
        self._rays = np.stack([np.cos(bearings), np.sin(bearings), np.zeros_like(bearings)], axis=1)
        self._cast = Rays(model, int(model.site_bodyid[self._site]))
        self._taken: tuple[float, Array] = (math.nan, np.empty(len(bearings)))

    @classmethod
    def prepare(cls, model: Any, name: str, parameters: Mapping[str, Any]) -> None:
        wanted = _read(parameters, name, among="declares" not in vars(cls)).site
        known = [site.name for site in model.sites if site.name and "/" not in site.name]
        if wanted not in known:
            raise InputError(unknown(f"site for sensor '{name}'", wanted, known, "The model"))

    def sample(self) -> list[float]:
        distances: list[float] = self._scan().tolist()
        return distances

    def read(self) -> Reading:
        world, (low, high) = self.mount.world, self.parameters.range
        with world.lock:
            if world.stamp != self._taken[0]:  # a second look at the same instant says the same
                ranges = self._scan()
                if self.mount.noise > 0.0:
                    ranges = ranges + self.mount.rng.normal(0.0, self.mount.noise, len(ranges))
                np.maximum(ranges, low, out=ranges)
                ranges[ranges > high] = math.inf
                self._taken = world.stamp, ranges
            return Reading(world.stamp, self._taken[1].tolist())

    def fan(self) -> Fan:
        """Where its rays begin and look, in the body frame."""
        element = self.mount.world.model.site(self._site)
        (x, y, _), (w, i, j, k) = element.pos.tolist(), element.quat.tolist()
        yaw = math.atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k))
        first, second = self.parameters.bearings[:2]
        count, reach = self.parameters.rays, self.parameters.range[1]
        return Fan(x=x, y=y, yaw=yaw + first, step=second - first, rays=count, reach=reach)

    def _scan(self) -> Array:
        """(rays,) Distances [m] in the present state, +inf where there is nothing."""
        self.mount.world.update_poses()
        data = self.mount.world.data
        directions = self._rays @ data.site_xmat[self._site].reshape(3, 3).T
        # A little farther than it sees, so that what is told of its edge does not depend on the cut.
        cutoff = self.parameters.range[1] + 1.0
        distances = self._cast.distances(data, data.site_xpos[self._site], directions, cutoff)
        found: Array = np.where(distances < 0.0, math.inf, distances)
        return found


def _read(parameters: Mapping[str, Any], name: str, *, among: bool = False) -> LidarParameters:
    return read_parameters(LidarParameters, parameters, f"lidar '{name}'", among=among)


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
