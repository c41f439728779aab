"""Base classes of users' devices in MuJoCo, which know the whole world, not only a `Scene`."""

from __future__ import annotations

from typing import Any

from ..simulated.device import Bound, SimulatedActuator, SimulatedSensor
from .world import MujocoWorld


class _InMujoco(Bound):
    world: MujocoWorld


class MujocoSensor(_InMujoco, SimulatedSensor):
    """Base class of users' sensors in MuJoCo, which implement `sample`. Their fields are the keys in robot.toml."""

    def prepare(self, model: Any, name: str) -> None:
        """Add the elements that the sensor needs to a robot's model before MuJoCo compiles it; none by default.

        Args:
            model: `MjSpec` of the robot, in which names have no prefix yet.
            name: Name of the sensor in robot.toml.
        """


class MujocoActuator(_InMujoco, SimulatedActuator):
    """Base class of users' actuators in MuJoCo, which implement `command` and `neutral`, and may have an inner loop."""
