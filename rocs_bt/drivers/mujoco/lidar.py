"""A laser scanner in MuJoCo: all rays of a scan in one call."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ...device import Reading
from ...errors import InputError, unknown
from ..parameters import LidarParameters, read_parameters
from .sensor import Mount, MujocoSensor

Array = npt.NDArray[np.float64]


class Lidar(MujocoSensor):
    """Ranges [m] along rays from one site, from the right to the left; a scan is taken at one instant.

    The rays lie in the plane of the site and pitch with the robot. They pass through the body that carries the scanner.
    """

    def __init__(self, name: str, parameters: Mapping[str, Any], mount: Mount) -> None:
        super().__init__(name, parameters, mount)
        import mujoco

        self.parameters = _read(parameters, name)
        model = mount.world.model
        self._cast = mujoco.mj_multiRay
        self._site = model.site(f"{mount.robot}/{self.parameters.site}").id
        self._body = int(model.site_bodyid[self._site])
        bearings = np.array(self.parameters.bearings)
        self._rays = np.stack([np.cos(bearings), np.sin(bearings), np.zeros_like(bearings)], axis=1)
        self._hit = np.empty(len(bearings), dtype=np.int32)
        self._distance = np.empty(len(bearings))
        self._taken: tuple[float, Array] = (math.nan, self._distance)

    @classmethod
    def prepare(cls, model: Any, name: str, parameters: Mapping[str, Any]) -> None:
        wanted = _read(parameters, name).site
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

    def _scan(self) -> Array:
        """(rays,) Distances [m] in the present state, +inf where there is nothing."""
        world, rays = self.mount.world, len(self._rays)
        world.update_poses()
        data = world.data
        directions = self._rays @ data.site_xmat[self._site].reshape(3, 3).T
        # A little farther than it sees, so that what is told of its edge does not depend on the cut.
        cutoff = self.parameters.range[1] + 1.0
        self._cast(
            world.model,
            data,
            data.site_xpos[self._site],
            directions.ravel(),
            None,
            True,
            self._body,
            self._hit,
            self._distance,
            None,
            rays,
            cutoff,
        )
        found: Array = np.where(self._distance < 0.0, math.inf, self._distance)
        return found


def _read(parameters: Mapping[str, Any], name: str) -> LidarParameters:
    return read_parameters(LidarParameters, parameters, f"lidar '{name}'")
