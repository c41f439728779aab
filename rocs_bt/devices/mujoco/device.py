"""Base classes of users' devices in MuJoCo, which know the whole world, not only a `Scene`."""

from __future__ import annotations

from typing import cast

from ..simulated.device import Bound, SimulatedActuator, SimulatedSensor
from .world import MujocoWorld


class _InMujoco(Bound):
    world = cast(MujocoWorld, None)


class MujocoSensor(_InMujoco, SimulatedSensor):
    """Base class of users' sensors in MuJoCo, which implement `sample`. Their fields are the keys in robot.toml."""


class MujocoActuator(_InMujoco, SimulatedActuator):
    """Base class of users' actuators in MuJoCo, which implement `command` and `neutral`, and may have an inner loop."""
