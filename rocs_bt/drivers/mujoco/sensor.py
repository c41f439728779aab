"""The common part of all sensors in MuJoCo."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from ...device import Reading, Sensor
from .mount import Mount


class MujocoSensor(Sensor):
    """Base of all sensors in MuJoCo; a user's own driver extends it and implements `sample`.

    The keyword-only parameters of a subclass's constructor are the keys that its table in robot.toml may have.

    Args:
        name: The sensor's name in robot.toml.
        mount: The robot, the world, the noise.

    Attributes:
        mount: The robot, the world, the noise.
        declares: The dataclass that declares a shipped driver's keys; None for a user's own driver.
    """

    declares: ClassVar[type | None] = None

    def __init__(self, name: str, mount: Mount) -> None:
        super().__init__(name)
        self.mount = mount
        self._drawn_at = math.nan
        self._errors: list[float] = []

    @classmethod
    def prepare(cls, model: Any, name: str, parameters: Mapping[str, Any]) -> None:
        """Add what the sensor needs to the robot's MjSpec before the world is compiled; nothing by default.

        Args:
            model: MuJoCo's `MjSpec` of the robot alone, without prefix.
            name: The sensor's name in robot.toml.
            parameters: The arguments that the constructor will get by keyword; an own driver that extends a shipped one
                passes them on as they are.
        """

    def sample(self) -> list[float]:
        """Values in the present state of the world, without noise [SI]; `mount.world.lock` is held."""
        raise NotImplementedError

    def read(self) -> Reading:
        mount, world = self.mount, self.mount.world
        with world.lock:
            values, stamp = self.sample(), world.stamp
            if mount.noise > 0.0:
                if stamp != self._drawn_at:  # a second look at the same instant says the same
                    self._drawn_at = stamp
                    self._errors = mount.rng.normal(0.0, mount.noise, len(values)).tolist()
                values = [v + e for v, e in zip(values, self._errors, strict=True)]
            return Reading(stamp, self.limit(values))

    def limit(self, values: list[float]) -> list[float]:
        """What the device makes of values that it cannot tell; the values themselves by default."""
        return values
