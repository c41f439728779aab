"""Two laser scanners, at the front and at the rear, merged into one scan around the base."""

from __future__ import annotations

import math

import numpy as np

from rocs_bt import Metres, Radians
from rocs_bt.devices.mujoco import MujocoSensor
from rocs_bt.devices.simulated import Lidar
from rocs_bt.record import Fan


class MergedScan(MujocoSensor):
    """Ranges [m] from the base along evenly spaced bearings, from right to left, +inf without an echo.

    The nearest echo of both scanners within half a step of a bearing counts. The scanners remove echoes of the robot's
    own legs.

    Attributes:
        sites: Sites of the scanners; their +x axis is the middle ray.
        rays: Number of bearings of the merged scan.
        span: Angle from the first to the last bearing [rad].
        scanner_rays: Number of rays of each scanner.
        scanner_span: Angle from the first to the last ray of each scanner [rad].
        range: Minimum and maximum range [m].
    """

    sites: tuple[str, ...]
    rays: int
    span: Radians
    scanner_rays: int
    scanner_span: Radians
    range: tuple[Metres, Metres]

    def mounted_at(self) -> tuple[str, ...]:
        """Sites that the model must have."""
        return self.sites

    def set_up(self) -> None:
        """Mount the scanners."""
        self._step, self._first, count = self.span / (self.rays - 1), -0.5 * self.span, self.scanner_rays
        each = [Lidar(site=site, rays=count, span=self.scanner_span, range=self.range) for site in self.sites]
        self._scanners = [lidar.bind(self.name, self.world, self.robot, self.rng, noise=self.noise) for lidar in each]
        ends = [self.world.direction(self.robot, site, "x") for site in self.sites]
        self._origins = np.concatenate([np.tile((x, y), (count, 1)) for x, y, _, _ in ends])
        directions = [
            yaw + np.linspace(-0.5 * self.scanner_span, 0.5 * self.scanner_span, count) for _, _, yaw, _ in ends
        ]
        self._directions = np.concatenate([np.stack([np.cos(a), np.sin(a)], axis=1) for a in directions])

    def fan(self) -> Fan:
        """Rays of the merged scan, body frame, for displays."""
        return Fan(x=0.0, y=0.0, yaw=self._first, step=self._step, rays=self.rays, reach=self.range[1])

    def sample(self) -> list[float]:
        ranges = np.array([value for scanner in self._scanners for value in scanner.read().values])
        seen = np.isfinite(ranges)
        x, y = (self._origins[seen] + ranges[seen, None] * self._directions[seen]).T
        nearest = np.rint((np.arctan2(y, x) - self._first) / self._step).astype(np.intp) % self.rays
        merged = np.full(self.rays, math.inf)
        np.minimum.at(merged, nearest, np.hypot(x, y))
        found: list[float] = merged.tolist()
        return found

    def limit(self, values: list[float]) -> list[float]:
        low, high = self.range
        return [max(value, low) if value <= high else math.inf for value in values]
