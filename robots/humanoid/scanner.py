"""A scanner with many layers in the head, which also sees low things around the robot."""

from __future__ import annotations

import math

import numpy as np

from rocs_bt import InputError, Metres, Radians
from rocs_bt.devices.mujoco import MujocoSensor, Rays


class LayeredScan(MujocoSensor):
    """Horizontal ranges [m] around the base along evenly spaced bearings, from right to left, +inf without an echo.

    The nearest echo of all layers counts. Echoes of the floor are removed by their height, which is known from the
    attitude of the body, and echoes of the robot's own legs by its joint angles, as drivers of real scanners do.

    Attributes:
        site: Site of the scanner, above the origin of the base and level with it.
        rays: Number of bearings.
        span: Angle from the first to the last bearing [rad].
        layers: Number of layers.
        elevations: Elevation of the lowest and the highest layer, up positive [rad].
        range: Minimum and maximum horizontal range [m].
        heights: Minimum and maximum height of an echo above the origin of the base [m].
    """

    site: str
    rays: int
    span: Radians
    layers: int
    elevations: tuple[Radians, Radians]
    range: tuple[Metres, Metres]
    heights: tuple[Metres, Metres]

    def mounted_at(self) -> tuple[str, ...]:
        """Sites that the model must have."""
        return (self.site,)

    def set_up(self) -> None:
        """Compute the directions of the rays."""
        layers, rays, heights = self.layers, self.rays, self.heights
        if layers < 1 or not heights[0] < heights[1]:
            found = f"layers = {layers}, heights = {list(heights)}"
            raise InputError(f"sensor '{self.name}' needs at least one layer and heights that rise, found {found}.")
        model, robot = self.world.model, self.robot
        self._site, self._base = model.site(f"{robot}/{self.site}").id, model.body(f"{robot}/base").id
        bearings = np.linspace(-0.5 * self.span, 0.5 * self.span, rays)
        up = np.linspace(*self.elevations, layers)[:, None]
        flat, ahead, left = np.cos(up), np.cos(bearings), np.sin(bearings)
        directions = np.stack(np.broadcast_arrays(flat * ahead, flat * left, np.sin(up)), axis=-1)
        self._directions, self._flat = directions.reshape(-1, 3), np.broadcast_to(flat, (layers, rays))
        self._cast = Rays(model, self._base)

    def sample(self) -> list[float]:
        world, data = self.world, self.world.data
        world.update_poses()
        directions = self._directions @ data.site_xmat[self._site].reshape(3, 3).T
        origin = data.site_xpos[self._site]
        found = self._cast.distances(data, origin, directions, 2.0 * self.range[1]).reshape(self._flat.shape)
        height = origin[2] - data.xpos[self._base, 2] + found * directions[:, 2].reshape(found.shape)
        ranges = found * self._flat
        seen = (found >= 0.0) & (height > self.heights[0]) & (height < self.heights[1])
        nearest: list[float] = np.where(seen, ranges, math.inf).min(axis=0).tolist()
        return nearest

    def limit(self, values: list[float]) -> list[float]:
        low, high = self.range
        return [max(value, low) if value <= high else math.inf for value in values]
