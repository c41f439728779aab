"""The common part of all sensors in MuJoCo."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ...device import Reading, Sensor

if TYPE_CHECKING:
    from .world import MujocoWorld


@dataclass(frozen=True)
class Mount:
    """Where a device sits.

    Attributes:
        world: The world.
        robot: The robot's name, which is the prefix of its elements.
        noise: Standard deviation of each value [SI].
        rng: Where the noise comes from; its own, so that no other device changes it.
    """

    world: MujocoWorld
    robot: str
    noise: float = 0.0
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))


class MujocoSensor(Sensor):
    """The common part; a user's own driver extends it and implements `sample`.

    Args:
        name: What robot.toml calls it.
        parameters: What robot.toml gives it, in SI units.
        mount: Where it sits.
    """

    def __init__(self, name: str, parameters: Mapping[str, Any], mount: Mount) -> None:
        super().__init__(name)
        self.mount = mount
        self._drawn_at = math.nan
        self._errors: list[float] = []

    @classmethod
    def prepare(cls, model: Any, name: str, parameters: Mapping[str, Any]) -> None:
        """Add what it needs to the robot's MjSpec, before the world is compiled; nothing by default."""

    def sample(self) -> list[float]:
        """What it says in the present state, without noise [SI]."""
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
