"""Wheels: speed-controlled motors and their encoders."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated

from ...base.errors import DeviceError
from ...base.units import ACCELERATION, NONE, TIME, Bounds, PositiveMetres
from ...declare import Value, Wrong
from .device import Bound, SimulatedActuator, SimulatedSensor


class _Motors(Bound, Value):
    """Motors of wheels, of which the devices take and give linear speeds.

    Attributes:
        motors: Names of the motors in the robot's model.
        wheel_radius: Wheel radius [m].
        signs: Sign of each motor, -1 for a motor that is mounted in reverse; all 1 by default.
    """

    motors: tuple[str, ...]
    wheel_radius: PositiveMetres
    signs: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        self.size = len(self.motors)

    def _check(self) -> Iterator[Wrong]:
        """Faults of the names of motors, and of signs that are none."""
        yield from name_faults("motors", "motor", self.motors)
        if self.signs and (len(self.signs) != self.size or any(sign not in (-1, 1) for sign in self.signs)):
            message = f"signs must be 1 or -1 for each of {self.size} motors, found {list(self.signs)}."
            yield Wrong("signs", message)

    @property
    def factors(self) -> list[float]:
        """Signed wheel radius of each motor [m]: wheel linear speed per angular speed of the motor."""
        return [s * self.wheel_radius for s in self.signs or (1,) * len(self.motors)]

    def set_up(self) -> None:
        self._factors, self.handle = self.factors, self.world.motors(self.robot, self.motors)

    def measured(self) -> list[float]:
        """True wheel linear speeds [m/s], in the order of the motors; those of the rims, also while they slip."""
        return [s * f for s, f in zip(self.world.motor_speeds(self.handle), self._factors, strict=True)]


class WheelSpeed(_Motors, SimulatedSensor):
    """Wheel encoders: wheel linear speeds [m/s] in the order of `motors`, measured at the motor shafts."""

    def sample(self) -> list[float]:
        return self.measured()


class WheelTravel(_Motors, SimulatedSensor):
    """Incremental encoders: wheel travel since the start [m], in whole counts, in the order of `motors`.

    It is measured at the motor shafts, so it includes slip.

    Attributes:
        counts: Encoder counts per wheel revolution.
    """

    counts: Annotated[int, Bounds(1)]

    def sample(self) -> list[float]:
        each = math.tau / self.counts
        angles = self.world.motor_angles(self.handle)
        return [math.floor(a / each) * each * factor for a, factor in zip(angles, self._factors, strict=True)]


class Velocity(_Motors, SimulatedActuator):
    """Speed-controlled motors, commanded by wheel linear speeds [m/s] in the order of `motors`.

    The acceleration limit applies to every command, also to braking by `neutral`. Commands take effect after a delay.

    Attributes:
        max_acceleration: Acceleration limit of the motor controllers, as linear acceleration of the wheels [m/s2].
        delay: Delay until a command takes effect [s]; a whole number of physics steps.
        slip: Share of the commanded travel that each wheel loses by slip, in the order of `motors`, or one share for
            all wheels; encoders do not see it.
    """

    max_acceleration: Annotated[float, ACCELERATION, Bounds(0.0, above=True, infinite=True)] = math.inf
    delay: Annotated[float, TIME, Bounds(0.0, 10.0)] = 0.0
    slip: tuple[Annotated[float, NONE, Bounds(0.0, 1.0, below=True)], ...] = ()

    def _check(self) -> Iterator[Wrong]:
        """Faults of the motors, and of a number of shares that is not that of the wheels."""
        yield from super()._check()
        if len(self.slip) not in (0, 1, self.size):
            message = f"slip must be one share for all wheels or one for each of {self.size}, found {list(self.slip)}."
            yield Wrong("slip", message)

    def set_up(self) -> None:
        self._factors, change = self.factors, self.max_acceleration / self.wheel_radius
        self.handle = self.world.motors(self.robot, self.motors, change, self.delay, self.wheel_radius, self.slip)

    def command(self, values: Sequence[float]) -> None:
        if len(values) != self.size:
            raise DeviceError(f"actuator '{self.name}' takes {self.size} wheel speeds, found {len(values)}.")
        self.world.drive(self.handle, [v / f for v, f in zip(values, self._factors, strict=True)])

    def neutral(self) -> None:
        self.world.drive(self.handle, [0.0] * self.size)


def name_faults(key: str, what: str, names: tuple[str, ...]) -> Iterator[Wrong]:
    """Faults of names of elements of the model, of which a device needs at least one."""
    if not names:
        yield Wrong(key, f"{key} must name at least one {what} of the model, found none.")
    if twice := sorted({name for name in names if names.count(name) > 1}):
        yield Wrong(key, f"{key} must name each element of the model once, found {', '.join(twice)} twice.")
