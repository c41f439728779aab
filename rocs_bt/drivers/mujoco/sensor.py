"""MujocoSensor: base class of all sensors in MuJoCo."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from ...declare import Value
from ...interfaces.device import Reading, Sensor
from ..common import Delivery
from .mount import Mount


class MujocoSensor(Sensor):
    """Base class of all sensors in MuJoCo. A user's driver derives from it and implements `sample`.

    The keyword-only parameters of the constructor of a derived class are the keys of its table in robot.toml.

    Args:
        name: Name of the sensor in robot.toml.
        mount: Robot, world and noise.

    Attributes:
        mount: Robot, world and noise.
        declares: Class that declares the keys of a shipped driver; None for a user's driver.
    """

    declares: ClassVar[type[Value] | None] = None

    def __init__(self, name: str, mount: Mount) -> None:
        super().__init__(name)
        self.mount = mount
        self._sampled_at = math.nan
        self._errors: list[float] = []
        self._delivery = Delivery(mount.latency, mount.drop_out, mount.faults_rng())

    @classmethod
    def prepare(cls, model: Any, name: str, parameters: Mapping[str, Any]) -> None:
        """Add the elements that the sensor needs to the robot's MjSpec before compilation; none by default.

        Args:
            model: `MjSpec` of the robot, in which names have no prefix yet.
            name: Name of the sensor in robot.toml.
            parameters: Keyword arguments of the constructor. A user's driver that extends a shipped driver must pass
                them on unchanged.
        """

    def sample(self) -> list[float]:
        """Compute the values in the present state of the world, SI units, without noise; `mount.world.lock` is held."""
        raise NotImplementedError

    def read(self) -> Reading:
        world = self.mount.world
        with world.lock:
            return self._delivery.deliver(self.measure(), world.stamp)

    def measure(self) -> Reading:
        """Measure in the present state of the world: `sample` with noise and limits; `mount.world.lock` is held."""
        mount, stamp = self.mount, self.mount.world.stamp
        values = self.sample()
        if mount.noise > 0.0:
            if stamp != self._sampled_at:  # a repeated reading at the same time is equal
                self._sampled_at = stamp
                self._errors = mount.rng.normal(0.0, mount.noise, len(values)).tolist()
            values = [v + e for v, e in zip(values, self._errors, strict=True)]
        return Reading(stamp, self.limit(values))

    def limit(self, values: list[float]) -> list[float]:
        """Limit values, after noise was added, to the measuring range of the device; by default they are unchanged."""
        return values
