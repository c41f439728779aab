"""Two laser scanners, at the front and at the rear, merged into one scan around the base."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from rocs_bt import Metres, Radians
from rocs_bt.drivers.mujoco import SENSORS, Mount, MujocoSensor
from rocs_bt.record import Fan

LIDAR: Any = SENSORS["lidar"]  # called with the keys of its table


class MergedScan(MujocoSensor):
    """Ranges [m] from the base along evenly spaced bearings, from right to left, +inf without an echo.

    The nearest echo of both scanners within half a step of a bearing counts. The scanners remove echoes of the robot's
    own legs.

    Args:
        name: Name of the sensor in robot.toml.
        mount: Robot, world and noise of each scanner's range.
        sites: Sites of the scanners; their +x axis is the middle ray.
        rays: Number of bearings of the merged scan.
        span: Angle from the first to the last bearing [rad].
        scanner_rays: Number of rays of each scanner.
        scanner_span: Angle from the first to the last ray of each scanner [rad].
        range: Minimum and maximum range [m].
    """

    def __init__(
        self,
        name: str,
        mount: Mount,
        *,
        sites: tuple[str, ...],
        rays: int,
        span: Radians,
        scanner_rays: int,
        scanner_span: Radians,
        range: tuple[Metres, Metres],
    ) -> None:
        super().__init__(name, mount)
        self._rays, self._step = rays, span / (rays - 1)
        self._first, self._range = -0.5 * span, range
        each = {"rays": scanner_rays, "span": scanner_span, "range": range}
        self._scanners = [LIDAR(name, mount, site=site, **each) for site in sites]
        bearings = np.linspace(-0.5 * scanner_span, 0.5 * scanner_span, scanner_rays)
        ends = [_in_base(mount, site) for site in sites]
        self._origins = np.concatenate([np.tile(origin, (scanner_rays, 1)) for origin, _ in ends])
        directions = [yaw + bearings for _, yaw in ends]
        self._directions = np.concatenate([np.stack([np.cos(a), np.sin(a)], axis=1) for a in directions])

    @classmethod
    def prepare(cls, model: Any, name: str, parameters: Mapping[str, Any]) -> None:
        for site in parameters["sites"]:
            LIDAR.prepare(model, name, {"site": site, "rays": 2, "span": 1.0, "range": parameters["range"]})

    def fan(self) -> Fan:
        """Rays of the merged scan, body frame, for displays."""
        return Fan(x=0.0, y=0.0, yaw=self._first, step=self._step, rays=self._rays, reach=self._range[1])

    def sample(self) -> list[float]:
        ranges = np.array([value for scanner in self._scanners for value in scanner.read().values])
        seen = np.isfinite(ranges)
        x, y = (self._origins[seen] + ranges[seen, None] * self._directions[seen]).T
        nearest = np.rint((np.arctan2(y, x) - self._first) / self._step).astype(np.intp) % self._rays
        merged = np.full(self._rays, math.inf)
        np.minimum.at(merged, nearest, np.hypot(x, y))
        found: list[float] = merged.tolist()
        return found

    def limit(self, values: list[float]) -> list[float]:
        low, high = self._range
        return [max(value, low) if value <= high else math.inf for value in values]


def _in_base(mount: Mount, site: str) -> tuple[np.ndarray[Any, Any], float]:
    """Position of a site in the base frame, x and y [m], and the direction of its x axis [rad]."""
    element = mount.world.model.site(f"{mount.robot}/{site}")
    w, i, j, k = element.quat.tolist()
    return element.pos[:2].copy(), math.atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k))
