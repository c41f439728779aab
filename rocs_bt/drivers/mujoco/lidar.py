"""A laser scanner in MuJoCo: all rays of a scan in one call."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ...device import Reading
from ...errors import InputError, unknown
from ...record.header import Fan
from ..parameters import LidarParameters, read_parameters
from .mount import Mount
from .rays import Rays
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
