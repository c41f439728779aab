"""Range sensors: rings of sonars and laser scanners."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import numpy as np

from ...base.units import ANGLE, LENGTH, TIME, Bounds
from ...declare import Wrong
from ...interfaces.device import Reading
from .device import SimulatedSensor
from .pose import Distance, Share
from .scene import Array
from .wheels import name_faults

if TYPE_CHECKING:
    from ...record.file.header import Beam, Fan

MAX_SIZE = 1000
"""Maximum number of rays per beam, or of slots, of a sensor, so that a typing error cannot stall the machine."""

Count = Annotated[int, Bounds(1, MAX_SIZE)]

MAX_LIDAR_RAYS = 4000
"""Maximum number of rays in a scan of a lidar."""

MAX_SWEEP = 1.0
"""Maximum sweep of a scan of a lidar [s]."""


class RangeCone(SimulatedSensor):
    """Ring of range sensors with conical beams: range of each beam [m], +inf without an echo.

    Attributes:
        sites: Sites of the model, one per beam; the axis of the beam is the +z axis of the site.
        range: Minimum and maximum range [m]; smaller distances are reported as the minimum.
        half_angle: Half the opening angle of a beam [rad].
        rays: Number of rays per beam and layer, evenly spaced over the opening angle; the nearest hit is the range.
        layers: Number of layers of rays, evenly spaced over the opening angle; one is a fan in the plane of the body.
        missing_echo: Probability that a beam gives no echo, for each beam and reading.
    """

    sites: tuple[str, ...]
    range: tuple[Distance, Annotated[float, LENGTH, Bounds(0.0, infinite=True)]]
    half_angle: Annotated[float, ANGLE, Bounds(0.0, math.pi / 2, below=True)] = 0.0
    rays: Count = 1
    layers: Count = 1
    missing_echo: Share = 0.0

    def _check(self) -> Iterator[Wrong]:
        """Faults of the names of sites, and of a range that is none."""
        yield from name_faults("sites", "site", self.sites)
        yield from _span(self.range)

    @property
    def size(self) -> int:
        """Number of values of a reading."""
        return len(self.sites)

    def mounted_at(self) -> tuple[str, ...]:
        return self.sites

    def beam_angles(self) -> list[tuple[float, float]]:
        """Angles between each ray of a beam and its axis, left and up positive [rad]."""
        return [(left, up) for up in self._spread(self.layers) for left in self._spread(self.rays)]

    def _spread(self, count: int) -> list[float]:
        return [self.half_angle * (2.0 * i / (count - 1) - 1.0) for i in range(count)] if count > 1 else [0.0]

    def set_up(self) -> None:
        self._cast = self.world.beams(self.robot, self.name, self.sites, self.beam_angles())
        self._faults_rng = self.faults_rng()

    def measure(self) -> Reading:
        return Reading(self.world.stamp, _echoes(self, self._faults_rng, self._cast().min(axis=1)))

    def beams(self) -> tuple[Beam, ...]:
        """Origins and directions of the beams, body frame, for displays."""
        from ...record.file.header import Beam

        found, (nearest, reach), cone = [], self.range, 2.0 * self.half_angle
        for site in self.sites:
            x, y, yaw, up = self.world.direction(self.robot, site, "z")
            beam = Beam(x=x, y=y, yaw=yaw, reach=reach, nearest=nearest, name=site, cone=cone, elevation=up)
            found.append(beam)
        return tuple(found)


class Lidar(SimulatedSensor):
    """Laser scanner: ranges [m] along rays from one point, from right to left, +inf without an echo.

    The rays lie in the x-y plane of the site, so they pitch with the robot. Echoes of the robot itself are removed.

    Attributes:
        site: Site of the model at the origin of the rays; its +x axis is ahead, its +y axis left.
        rays: Number of rays per scan.
        span: Angle from the first to the last ray [rad], centred ahead.
        range: Minimum and maximum range [m]; smaller distances are reported as the minimum.
        missing_echo: Probability that a ray gives no echo, for each ray and scan.
        sweep: Time from the first ray of a scan to the last; the time stamp of the scan is that of the first [s].
    """

    site: str
    rays: Annotated[int, Bounds(2, MAX_LIDAR_RAYS)]
    span: Annotated[float, ANGLE, Bounds(0.0, math.tau, above=True)]
    range: tuple[Distance, Distance]
    missing_echo: Share = 0.0
    sweep: Annotated[float, TIME, Bounds(0.0, MAX_SWEEP)] = 0.0

    def _check(self) -> Iterator[Wrong]:
        """Faults of a range that is none."""
        yield from _span(self.range)

    @property
    def size(self) -> int:
        """Number of values of a reading."""
        return self.rays

    def mounted_at(self) -> tuple[str, ...]:
        return (self.site,)

    @property
    def bearings(self) -> list[float]:
        """Directions of the rays, sensor frame, left positive [rad]."""
        return [self.span * (i / (self.rays - 1) - 0.5) for i in range(self.rays)]

    def set_up(self) -> None:
        # The reach is above the maximum range, so that it does not affect readings near this range.
        self._cast = self.world.scan(self.robot, self.site, self.bearings, self.range[1] + 1.0, self.sweep)
        self._faults_rng = self.faults_rng()
        self._started = self.world.stamp

    def measure(self) -> Reading:
        stamp = max(self.world.stamp - self.sweep, self._started)
        return Reading(stamp, _echoes(self, self._faults_rng, self._cast()))

    def fan(self) -> Fan:
        """Origin and directions of the rays, body frame, for displays."""
        from ...record.file.header import Fan

        x, y, yaw, _ = self.world.direction(self.robot, self.site, "x")
        first, second = self.bearings[:2]
        nearest, reach = self.range
        return Fan(
            x=x,
            y=y,
            yaw=yaw + first,
            step=second - first,
            rays=self.rays,
            reach=reach,
            nearest=nearest,
            sweep=self.sweep,
        )


def _echoes(sensor: RangeCone | Lidar, faults_rng: np.random.Generator, ranges: Array) -> list[float]:
    """Measured ranges of true ones [m]: with noise, limited to the measuring range, some without an echo."""
    if sensor.noise > 0.0:
        ranges = ranges + sensor.rng.normal(0.0, sensor.noise, len(ranges))
    low, high = sensor.range
    np.maximum(ranges, low, out=ranges)
    ranges[ranges > high] = math.inf
    if sensor.missing_echo:
        ranges[faults_rng.random(len(ranges)) < sensor.missing_echo] = math.inf
    found: list[float] = ranges.tolist()
    return found


def _span(found: tuple[float, float]) -> Iterator[Wrong]:
    """Fault of a range of distances of which the maximum is not above the minimum."""
    if not found[0] < found[1]:
        yield Wrong("range", f"range must be the minimum and the maximum distance, found {list(found)} m.")
