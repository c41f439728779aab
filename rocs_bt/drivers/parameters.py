"""Drivers: the keys of robot.toml that each takes, the same in every backend, and the class of a name.

The keyword-only parameters of the `__init__` of a user's own driver are its keys; their annotations are the units:

    class Beacon(MujocoSensor):
        def __init__(self, name, mount, *, reach: Metres = 10.0):
            super().__init__(name, mount)
            self.reach = reach
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

from ..arguments import keyword_parameters
from ..errors import Fault, InputError, UnknownName, unknown
from ..parameter import Parameter, misfit
from ..units import Bounds, Metres, MetresPerSecondSquared, Radians, RadiansPerSecond, Seconds

T = TypeVar("T")

MOST = 1000
"""Rays for a beam, or slots, that a sensor may have: more would stall the machine before anybody learns why."""

MOST_RAYS = 4000
"""Rays in a lidar's scan, likewise."""


@dataclass(frozen=True, kw_only=True)
class PositionParameters:
    """Where the body is: x, y, z [m] in the world frame."""

    size: ClassVar[int] = 3


@dataclass(frozen=True, kw_only=True)
class OrientationParameters:
    """Where the body heads: yaw [rad] in the world frame."""

    size: ClassVar[int] = 1


@dataclass(frozen=True, kw_only=True)
class RangeConeParameters:
    """A ring of range sensors that see cones: the nearest of a fan of rays each [m], +inf without an echo.

    Attributes:
        sites: The model's sites, one for each beam, whose +z axis looks along it.
        range: Least and greatest distance seen [m]; nearer things are told as the least.
        half_angle: Half the opening of a cone [rad].
        rays: Rays in each fan, spread evenly over the cone.
    """

    sites: tuple[str, ...]
    range: tuple[Metres, ...]
    half_angle: Radians = 0.0
    rays: int = 1

    def __post_init__(self) -> None:
        if not self.sites:
            raise InputError(Fault("sites must name at least one site of the model, found none."))
        _check_distinct("sites", self.sites)
        if len(self.range) != 2 or not 0.0 <= self.range[0] < self.range[1]:
            raise InputError(Fault(f"range must be two distances, the lesser first, found {list(self.range)} m."))
        if not 1 <= self.rays <= MOST:
            raise InputError(Fault(f"rays must be 1 to {MOST} for each beam, found {self.rays}."))
        if not 0.0 <= self.half_angle < math.pi / 2:
            raise InputError(
                Fault(f"half_angle must be less than 90 deg, found {math.degrees(self.half_angle):.4g} deg.")
            )

    @property
    def size(self) -> int:
        """How many values a reading has."""
        return len(self.sites)

    @property
    def angles(self) -> list[float]:
        """The rays of a fan, as angles from the beam's axis, left positive [rad]."""
        if self.rays == 1:
            return [0.0]
        return [self.half_angle * (2.0 * i / (self.rays - 1) - 1.0) for i in range(self.rays)]


@dataclass(frozen=True, kw_only=True)
class LidarParameters:
    """A laser scanner: ranges [m] along rays from one point, from the right to the left, +inf without an echo.

    Attributes:
        site: The model's site where the rays begin; its +x looks ahead and its +y to the left.
        rays: In one scan.
        span: From the first ray to the last [rad]; centred ahead.
        range: Least and greatest distance seen [m]; nearer things are told as the least.
    """

    site: str
    rays: int
    span: Radians
    range: tuple[Metres, ...]

    def __post_init__(self) -> None:
        if len(self.range) != 2 or not 0.0 <= self.range[0] < self.range[1] < math.inf:
            raise InputError(Fault(f"range must be two distances, the lesser first, found {list(self.range)} m."))
        if not 2 <= self.rays <= MOST_RAYS:
            raise InputError(Fault(f"rays must be 2 to {MOST_RAYS}, found {self.rays}."))
        if not 0.0 < self.span <= math.tau:
            raise InputError(Fault(f"span must be up to 360 deg, found {math.degrees(self.span):.4g} deg."))

    @property
    def size(self) -> int:
        """How many values a reading has."""
        return self.rays

    @property
    def bearings(self) -> list[float]:
        """The rays' directions in the sensor's frame, left positive [rad]."""
        return [self.span * (i / (self.rays - 1) - 0.5) for i in range(self.rays)]


@dataclass(frozen=True, kw_only=True)
class RobotSensorParameters:
    """Sees other robots and reads which they are: for each slot tag, range [m] and bearing [rad], the nearest first.

    Robots wear tags: numbers from 1, in the order in which the world has them. Ranges and bearings (left positive) go
    from the centre of the base to that of the other's. A slot in which there is nobody says tag 0, range +inf and
    bearing 0: that is valid, as a range without an echo is.

    Attributes:
        reach: Greatest range seen [m].
        slots: How many robots it can tell at once; of more the nearest.
        half_angle: Half its field of view, which is centred ahead [rad].
        range_noise: Standard deviation of a range [m].
        bearing_noise: Standard deviation of a bearing [rad].
        height: Of its line of sight over the floor: what is lower hides nobody [m].
    """

    reach: Metres
    slots: int = 4
    half_angle: Radians = math.pi
    range_noise: Metres = 0.0
    bearing_noise: Radians = 0.0
    height: Metres = 0.2

    def __post_init__(self) -> None:
        if not 1 <= self.slots <= MOST:
            raise InputError(Fault(f"slots must be 1 to {MOST}, found {self.slots}."))
        if not self.reach > 0.0 or not 0.0 < self.half_angle <= math.pi:
            raise InputError(
                Fault(
                    "a robot sensor needs a positive reach and up to 180 deg to a side, found "
                    f"{self.reach} m and {math.degrees(self.half_angle):.4g} deg."
                )
            )
        if not (0.0 <= self.range_noise < math.inf and 0.0 <= self.bearing_noise < math.inf and self.height > 0.0):
            raise InputError(
                Fault(
                    "range_noise and bearing_noise must be 0 or more and height positive, found "
                    f"{self.range_noise} m, {self.bearing_noise} rad and {self.height} m."
                )
            )

    @property
    def size(self) -> int:
        """How many values a reading has."""
        return 3 * self.slots


@dataclass(frozen=True, kw_only=True)
class WheelSpeedParameters:
    """Wheel encoders: rim speeds [m/s] in the order of `motors`.

    Attributes:
        motors: The model's motors.
        wheel_radius: From the motor's shaft to the rim [m].
        signs: -1 for a motor that is mounted the other way round; all 1 by default.
    """

    motors: tuple[str, ...]
    wheel_radius: Metres
    signs: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        _check_motors(self.motors, self.signs, self.wheel_radius)

    @property
    def size(self) -> int:
        """How many values a reading, or a command, has."""
        return len(self.motors)

    @property
    def factors(self) -> list[float]:
        """Rim speed for each rad/s of a motor, by motor [m]."""
        return [s * self.wheel_radius for s in self.signs or (1,) * len(self.motors)]


@dataclass(frozen=True, kw_only=True)
class WheelTravelParameters(WheelSpeedParameters):
    """Incremental encoders: how far each rim has rolled since the start [m], in whole counts, in the order of `motors`.

    Attributes:
        counts: For one revolution of a wheel.
    """

    counts: int

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.counts < 1:
            raise InputError(Fault(f"counts must be at least 1 for a revolution of the wheel, found {self.counts}."))

    def travel(self, angles: Sequence[float]) -> list[float]:
        """How far rims have rolled [m], by how far the motors have turned [rad]."""
        each = math.tau / self.counts
        return [math.floor(a / each) * each * factor for a, factor in zip(angles, self.factors, strict=True)]


@dataclass(frozen=True, kw_only=True)
class GyroParameters:
    """How fast the body turns: the mean yaw rate since the reading before [rad/s], left positive.

    Attributes:
        bias: Standard deviation of the constant error that a device has from the start [rad/s].
    """

    size: ClassVar[int] = 1
    bias: RadiansPerSecond = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.bias < math.inf:
            raise InputError(Fault(f"bias must be 0 or more and finite, found {self.bias} rad/s."))


@dataclass(frozen=True, kw_only=True)
class VelocityParameters(WheelSpeedParameters):
    """Motors that hold a speed; commanded with rim speeds [m/s] in the order of `motors`.

    Attributes:
        max_acceleration: How fast the motors' own electronics let a rim speed change [m/s2].
        delay: How much later than it is given a command begins to act [s]; a whole number of physics steps.
    """

    max_acceleration: MetresPerSecondSquared = math.inf
    delay: Seconds = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 <= self.delay <= 10.0:
            raise InputError(Fault(f"delay must be 0 to 10 s, found {self.delay} s."))
        if not self.max_acceleration > 0.0:
            raise InputError(Fault(f"max_acceleration must be positive, found {self.max_acceleration} m/s2."))


@dataclass(frozen=True, kw_only=True)
class MailboxParameters:
    """What other robots said: of each message the bytes of its sender and its text; no values while there is none."""

    size: ClassVar[int | None] = None


DRIVER_PARAMETERS: Mapping[str, type] = {
    "position": PositionParameters,
    "orientation": OrientationParameters,
    "range_cone": RangeConeParameters,
    "lidar": LidarParameters,
    "robot_sensor": RobotSensorParameters,
    "wheel_speed": WheelSpeedParameters,
    "wheel_travel": WheelTravelParameters,
    "gyro": GyroParameters,
    "mailbox": MailboxParameters,
    "velocity": VelocityParameters,
}


def parameters_of_driver(declared: type) -> dict[str, Parameter]:
    """The keys that a driver's dataclass declares, by name, in their order; what is infinite it judges itself."""
    hints = typing.get_type_hints(declared, include_extras=True)
    found = {}
    for field in dataclasses.fields(declared):
        hint, required = hints[field.name], field.default is dataclasses.MISSING
        each = typing.get_args(hint)[0] if typing.get_origin(hint) is tuple else hint
        dimension = Parameter.annotated(field.name, each, required, None).dimension
        kind = Parameter.annotated(field.name, hint, required, None).type
        default = None if required else field.default
        found[field.name] = Parameter(field.name, kind, dimension, required, default, Bounds(infinite=True))
    return found


def read_parameters(declared: type[T], values: Mapping[str, Any], what: str, *, among: bool = False) -> T:
    """A driver's parameters from what robot.toml holds, already in SI units.

    Args:
        declared: The driver's dataclass.
        values: By name: floats, whole numbers, texts, or lists of them.
        what: The device and its driver, for messages.
        among: Whether there may be others among them, as for a user's own driver that extends this one.

    Raises:
        InputError: Unknown, missing or wrong parameters; with every fault.
    """
    specs = parameters_of_driver(declared)
    others = [name for name in values if name not in specs]
    faults = [] if among else [unknown(f"parameter of {what}", name, specs, what) for name in others]
    missing = [s.name for s in specs.values() if s.required and s.name not in values]
    if missing:
        faults.append(Fault(f"{what} needs {', '.join(missing)}.", hint=f"It takes: {', '.join(specs)}."))
    given = {name: tuple(v) if isinstance(v, list) else v for name, v in values.items() if name in specs}
    wrong = {name: misfit(specs[name].type, value) for name, value in given.items()}
    faults += [Fault(f"{n} of {what} must be {w}, found {values[n]!r}.") for n, w in wrong.items() if w is not None]
    if faults:
        raise InputError(*faults)
    try:
        return declared(**given)
    except InputError as error:
        raise InputError(*(dataclasses.replace(f, message=f"{what}: {f.message}") for f in error.faults)) from error


def _check_motors(motors: tuple[str, ...], signs: tuple[int, ...], wheel_radius: float) -> None:
    if not motors:
        raise InputError(Fault("motors must name at least one motor of the model, found none."))
    _check_distinct("motors", motors)
    if signs and (len(signs) != len(motors) or any(s not in (-1, 1) for s in signs)):
        raise InputError(Fault(f"signs must be one of 1 and -1 for each of {len(motors)} motors, found {list(signs)}."))
    if not wheel_radius > 0.0:
        raise InputError(Fault(f"wheel_radius must be positive, found {wheel_radius} m."))


def _check_distinct(what: str, names: tuple[str, ...]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(Fault(f"{what} must name each of the model's once, found {', '.join(twice)} twice."))


def constructor_parameters(cls: type, place: str) -> dict[str, Parameter]:
    """The keys that a driver's class takes, by name.

    A constructor that ends in `**rest` takes the keys of the class that it extends, too; a class that extends a
    shipped driver without a constructor of its own takes that driver's keys.

    Args:
        cls: The class.
        place: The constructor's second argument: `mount` in MuJoCo, `host` on hardware.

    Raises:
        InputError: A constructor has another form than `(self, name, mount, *, ...)`; all that is wrong with it.
    """
    found: dict[str, Parameter] = {}
    for base in cls.__mro__:
        if declared := vars(base).get("declares"):
            return found | {k: p for k, p in parameters_of_driver(declared).items() if k not in found}
        make = vars(base).get("__init__")
        if not inspect.isfunction(make):
            continue
        what, form = f"{base.__name__}.__init__", f"Write: def __init__(self, name, {place}, *, ...)."
        own, more = keyword_parameters(make, ("name", place), what, form)
        found |= {name: parameter for name, parameter in own.items() if name not in found}
        if not more:
            return found
    return found


def driver_class(drivers: Mapping[str, type[T]], driver: str | type[T], kind: str, backend: str) -> type[T]:
    """A driver's class.

    Args:
        drivers: The backend's classes by name.
        driver: What robot.toml names, or the class itself, for one of a user's own.
        kind: `sensor` or `actuator`.
        backend: Whose drivers these are.

    Raises:
        UnknownName: The backend has no such driver; lists those that it has.
    """
    if isinstance(driver, type):
        return driver
    if driver not in drivers:
        raise UnknownName(unknown(f"{kind} driver", driver, drivers, f"The {backend} backend"))
    return drivers[driver]
