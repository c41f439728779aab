"""Actuator drivers of the MuJoCo backend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from ...base.errors import DeviceError
from ...declare import Value, checked
from ...interfaces.device import Actuator
from ..parameters import VelocityParameters, driver_class
from .mount import Mount
from .world import MujocoWorld


class MujocoActuator(Actuator):
    """Base class of all actuators in MuJoCo. A user's driver derives from it and implements `command` and `neutral`.

    The keyword-only parameters of the constructor of a derived class are the keys of its table in robot.toml.

    Args:
        name: Name of the actuator in robot.toml.
        size: Number of values of a command.
        mount: Robot and world of the actuator.

    Attributes:
        mount: Robot and world of the actuator.
        declares: Class that declares the keys of a shipped driver; None for a user's driver.
    """

    declares: ClassVar[type[Value] | None] = None

    def __init__(self, name: str, size: int, mount: Mount) -> None:
        super().__init__(name, size)
        self.mount = mount

    def before_step(self, t: float) -> None:
        """Inner loop, called before each physics step at time t [s], also after the robot was stopped.

        A derived class may override it to set the controls of its robot (`mount.world.set_controls`); it must not wait.
        `mount.world.lock` is held, and all members of `mount.world` are those of the present state. `mount.rng` is the
        actuator's own random generator. An exception is a failure of the actuator, as in `command`; `neutral` follows,
        and the loop continues, because a body without wheels needs it to stay upright.
        """

    @property
    def has_loop(self) -> bool:
        """Whether a derived class overrides `before_step`."""
        return type(self).before_step is not MujocoActuator.before_step


class Velocity(MujocoActuator):
    """Speed-controlled motors, commanded by wheel linear speeds [m/s].

    The acceleration limit applies to every command, also to braking by `neutral`. Commands take effect after a delay.

    Args:
        name: Name of the actuator in robot.toml.
        mount: Robot and world of the actuator.
        parameters: Values of the fields of `VelocityParameters`.
    """

    declares = VelocityParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        wanted = checked(VelocityParameters, parameters, f"velocity actuator '{name}'")
        super().__init__(name, len(wanted.motors), mount)
        self._factors = wanted.factors
        max_change = wanted.max_acceleration / wanted.wheel_radius
        self._motors = mount.world.motors(
            mount.robot, wanted.motors, max_change, wanted.delay, wanted.wheel_radius, wanted.slip
        )

    def command(self, values: Sequence[float]) -> None:
        if len(values) != self.size:
            raise DeviceError(f"actuator '{self.name}' takes {self.size} wheel speeds, found {len(values)}.")
        self.mount.world.drive(self._motors, [v / f for v, f in zip(values, self._factors, strict=True)])

    def measured(self) -> list[float]:
        """True wheel linear speeds [m/s], in the order of the motors; those of the rims, also while they slip."""
        speeds = self.mount.world.motor_speeds(self._motors)
        return [s * f for s, f in zip(speeds, self._factors, strict=True)]

    def neutral(self) -> None:
        self.mount.world.drive(self._motors, [0.0] * self.size)


ACTUATORS: Mapping[str, type[MujocoActuator]] = {"velocity": Velocity}


def make_actuator(
    world: MujocoWorld,
    robot: str,
    name: str,
    driver: str | type[MujocoActuator],
    parameters: Mapping[str, Any],
    rng: np.random.Generator | None = None,
) -> Actuator:
    """Construct an actuator of a robot in the world, without a safety gate; its inner loop is not attached yet.

    Args:
        world: World of the robot.
        robot: Name of the robot.
        name: Name of the actuator in robot.toml.
        driver: Name of the driver, or a user's class, which is called with (name, mount, **parameters).
        parameters: Parameters of the driver, SI units.
        rng: Random generator of the actuator; a fixed one by default.

    Raises:
        InputError: The driver is unknown, or parameters do not fit the driver or the model.
    """
    world.body(robot)
    cls: Any = driver_class(ACTUATORS, driver, "actuator", "mujoco")
    mount = Mount(world, robot) if rng is None else Mount(world, robot, rng=rng)
    actuator: Actuator = cls(name, mount, **parameters)
    return actuator
