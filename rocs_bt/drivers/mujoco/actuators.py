"""Actuators in MuJoCo."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from ...device import Actuator
from ...errors import DeviceError
from ..parameters import VelocityParameters, driver_class, read_parameters
from .mount import Mount
from .world import MujocoWorld


class MujocoActuator(Actuator):
    """Base of all actuators in MuJoCo; a user's own driver extends it and implements `command` and `neutral`.

    The keyword-only parameters of a subclass's constructor are the keys that its table in robot.toml may have.

    Args:
        name: The actuator's name in robot.toml.
        size: Number of values of a command.
        mount: The robot and the world.

    Attributes:
        mount: The robot and the world.
        declares: The dataclass that declares a shipped driver's keys; None for a user's own driver.
    """

    declares: ClassVar[type | None] = None

    def __init__(self, name: str, size: int, mount: Mount) -> None:
        super().__init__(name, size)
        self.mount = mount


class Velocity(MujocoActuator):
    """Motors that hold the rim speeds [m/s] they are commanded, and get there as fast as their electronics allow.

    Neutral brakes them at that same rate. Whatever they are told acts after the delay of their electronics.

    Args:
        name: The actuator's name in robot.toml.
        mount: The robot and the world.
        parameters: Those of `VelocityParameters`.
    """

    declares = VelocityParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        wanted = read_parameters(VelocityParameters, parameters, f"velocity actuator '{name}'")
        super().__init__(name, len(wanted.motors), mount)
        self._factors = wanted.factors
        max_change = wanted.max_acceleration / wanted.wheel_radius
        self._motors = mount.world.motors(mount.robot, wanted.motors, max_change, wanted.delay)

    def command(self, values: Sequence[float]) -> None:
        if len(values) != self.size:
            raise DeviceError(f"actuator '{self.name}' takes {self.size} rim speeds, found {len(values)}.")
        self.mount.world.drive(self._motors, [v / f for v, f in zip(values, self._factors, strict=True)])

    def measured(self) -> list[float]:
        """How fast the rims truly go [m/s]."""
        speeds = self.mount.world.motor_speeds(self._motors)
        return [s * f for s, f in zip(speeds, self._factors, strict=True)]

    def neutral(self) -> None:
        self.mount.world.drive(self._motors, [0.0] * self.size)


ACTUATORS: Mapping[str, type[MujocoActuator]] = {"velocity": Velocity}


def make_actuator(
    world: MujocoWorld, robot: str, name: str, driver: str | type[MujocoActuator], parameters: Mapping[str, Any]
) -> Actuator:
    """An actuator of a robot in the world, not yet guarded.

    Args:
        world: The world.
        robot: The robot's name.
        name: What robot.toml calls the actuator.
        driver: Its driver's name, or a user's own class, which is called with (name, mount, **parameters).
        parameters: What the driver takes, in SI units.

    Raises:
        InputError: No such driver, or parameters that do not fit it or the model.
    """
    world.body(robot)
    cls: Any = driver_class(ACTUATORS, driver, "actuator", "mujoco")
    actuator: Actuator = cls(name, Mount(world, robot), **parameters)
    return actuator
