"""Parameters of drivers: the keys of each shipped driver in robot.toml, which are the same in all backends.

The keys of a user's driver are the keyword-only parameters of its constructor; annotations declare the units:

    class Beacon(MujocoSensor):
        def __init__(self, name, mount, *, max_range: Metres = 10.0):
            super().__init__(name, mount)
            self.max_range = max_range
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

from ..base.errors import Fault, InputError, UnknownName, unknown
from ..base.parameter import field_parameters, misfit
from ..base.registered import load, registered
from ..base.units import (
    Joules,
    Metres,
    MetresPerSecond,
    MetresPerSecondSquared,
    Radians,
    RadiansPerSecond,
    Seconds,
    Watts,
)

T = TypeVar("T")

MAX_SIZE = 1000
"""Maximum number of rays per beam, or of slots, of a sensor, so that a typing error cannot stall the machine."""

MAX_LIDAR_RAYS = 4000
"""Maximum number of rays in a scan of a lidar."""

MAX_SWEEP = 1.0
"""Maximum sweep of a scan of a lidar [s]."""


@dataclass(frozen=True, kw_only=True)
class PositionParameters:
    """Position sensor: x, y, z of the base [m], world frame.

    Attributes:
        odometry: Relative error of an odometer that replaces the true pose; 0 for the true pose.
        drift: Standard deviation of the change of the error of x and of y in a second, a random walk [m].
        jump: Standard deviation of the error of x and of y that is sampled again at each jump [m].
        jump_every: Mean time between two jumps [s]; they come at random.
    """

    size: ClassVar[int] = 3
    odometry: float = 0.0
    drift: Metres = 0.0
    jump: Metres = 0.0
    jump_every: Seconds = 10.0

    def __post_init__(self) -> None:
        _check_error(self.odometry, self.drift, self.jump, self.jump_every)


@dataclass(frozen=True, kw_only=True)
class OrientationParameters:
    """Orientation sensor: yaw of the base [rad], world frame.

    Attributes:
        odometry: Relative error of an odometer, as of a position sensor.
        drift: Standard deviation of the change of the error in a second, a random walk [rad].
        jump: Standard deviation of the error that is sampled again at each jump [rad].
        jump_every: Mean time between two jumps [s]; they come at random.
    """

    size: ClassVar[int] = 1
    odometry: float = 0.0
    drift: Radians = 0.0
    jump: Radians = 0.0
    jump_every: Seconds = 10.0

    def __post_init__(self) -> None:
        _check_error(self.odometry, self.drift, self.jump, self.jump_every)


@dataclass(frozen=True, kw_only=True)
class TwistParameters:
    """Twist sensor: velocity of the base, forward, left and up [m/s], and turn rate, left positive [rad/s].

    Forward and left are horizontal, up and the axis of the turn are vertical, also while the body tilts.

    Attributes:
        speed_noise: Standard deviation of each speed [m/s].
        turn_noise: Standard deviation of the turn rate [rad/s].
    """

    size: ClassVar[int] = 4
    speed_noise: MetresPerSecond = 0.0
    turn_noise: RadiansPerSecond = 0.0

    def __post_init__(self) -> None:
        if not (0.0 <= self.speed_noise < math.inf and 0.0 <= self.turn_noise < math.inf):
            found = f"{self.speed_noise} m/s and {self.turn_noise} rad/s"
            raise InputError(Fault(f"speed_noise and turn_noise must be 0 or more and finite, found {found}."))


@dataclass(frozen=True, kw_only=True)
class AttitudeParameters:
    """Attitude sensor: roll and pitch of the base [rad], as in `Pose3`."""

    size: ClassVar[int] = 2


@dataclass(frozen=True, kw_only=True)
class HeightParameters:
    """Height sensor: height of the base [m], world frame."""

    size: ClassVar[int] = 1


@dataclass(frozen=True, kw_only=True)
class RangeConeParameters:
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
    range: tuple[Metres, ...]
    half_angle: Radians = 0.0
    rays: int = 1
    layers: int = 1
    missing_echo: float = 0.0

    def __post_init__(self) -> None:
        _check_missing_echo(self.missing_echo)
        if not self.sites:
            raise InputError(Fault("sites must name at least one site of the model, found none."))
        _check_distinct("sites", self.sites)
        if len(self.range) != 2 or not 0.0 <= self.range[0] < self.range[1]:
            raise InputError(Fault(f"range must be the minimum and the maximum distance, found {list(self.range)} m."))
        for name in ("rays", "layers"):
            if not 1 <= getattr(self, name) <= MAX_SIZE:
                raise InputError(Fault(f"{name} must be 1 to {MAX_SIZE} for each beam, found {getattr(self, name)}."))
        if not 0.0 <= self.half_angle < math.pi / 2:
            raise InputError(
                Fault(f"half_angle must be less than 90 deg, found {math.degrees(self.half_angle):.4g} deg.")
            )

    @property
    def size(self) -> int:
        """Number of values of a reading."""
        return len(self.sites)

    @property
    def angles(self) -> list[tuple[float, float]]:
        """Angles between each ray of a beam and its axis, left and up positive [rad]."""
        return [(left, up) for up in self._spread(self.layers) for left in self._spread(self.rays)]

    def _spread(self, count: int) -> list[float]:
        return [self.half_angle * (2.0 * i / (count - 1) - 1.0) for i in range(count)] if count > 1 else [0.0]


@dataclass(frozen=True, kw_only=True)
class LidarParameters:
    """Laser scanner: ranges [m] along rays from one point, from right to left, +inf without an echo.

    Attributes:
        site: Site of the model at the origin of the rays; its +x axis is ahead, its +y axis left.
        rays: Number of rays per scan.
        span: Angle from the first to the last ray [rad], centred ahead.
        range: Minimum and maximum range [m]; smaller distances are reported as the minimum.
        missing_echo: Probability that a ray gives no echo, for each ray and scan.
        sweep: Time from the first ray of a scan to the last; the time stamp of the scan is that of the first [s].
    """

    site: str
    rays: int
    span: Radians
    range: tuple[Metres, ...]
    missing_echo: float = 0.0
    sweep: Seconds = 0.0

    def __post_init__(self) -> None:
        _check_missing_echo(self.missing_echo)
        if not 0.0 <= self.sweep <= MAX_SWEEP:
            raise InputError(Fault(f"sweep must be 0 to {MAX_SWEEP:g} s, found {self.sweep} s."))
        if len(self.range) != 2 or not 0.0 <= self.range[0] < self.range[1] < math.inf:
            raise InputError(Fault(f"range must be the minimum and the maximum distance, found {list(self.range)} m."))
        if not 2 <= self.rays <= MAX_LIDAR_RAYS:
            raise InputError(Fault(f"rays must be 2 to {MAX_LIDAR_RAYS}, found {self.rays}."))
        if not 0.0 < self.span <= math.tau:
            raise InputError(Fault(f"span must be up to 360 deg, found {math.degrees(self.span):.4g} deg."))

    @property
    def size(self) -> int:
        """Number of values of a reading."""
        return self.rays

    @property
    def bearings(self) -> list[float]:
        """Directions of the rays, sensor frame, left positive [rad]."""
        return [self.span * (i / (self.rays - 1) - 0.5) for i in range(self.rays)]


@dataclass(frozen=True, kw_only=True)
class RobotSensorParameters:
    """Robot sensor, which detects other robots: tag, range [m] and bearing [rad] for each slot, nearest first.

    A tag identifies a robot; tags are numbers from 1, in the order of the robots in the world. Ranges and bearings
    (left positive) are measured between the centres of the bases. An empty slot has tag 0, range +inf and bearing 0,
    which are valid values.

    Attributes:
        max_range: Maximum range [m].
        max_peers: Maximum number of robots in a reading, which contains the nearest ones.
        half_angle: Half the field of view, centred ahead [rad].
        range_noise: Standard deviation of a range [m].
        bearing_noise: Standard deviation of a bearing [rad].
        height: Height of the line of sight over the floor [m]; lower obstacles do not hide a robot.
    """

    max_range: Metres
    max_peers: int = 4
    half_angle: Radians = math.pi
    range_noise: Metres = 0.0
    bearing_noise: Radians = 0.0
    height: Metres = 0.2

    def __post_init__(self) -> None:
        if not 1 <= self.max_peers <= MAX_SIZE:
            raise InputError(Fault(f"max_peers must be 1 to {MAX_SIZE}, found {self.max_peers}."))
        if not self.max_range > 0.0 or not 0.0 < self.half_angle <= math.pi:
            raise InputError(
                Fault(
                    "a robot sensor needs a positive max_range and up to 180 deg to a side, found "
                    f"{self.max_range} m and {math.degrees(self.half_angle):.4g} deg."
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
        """Number of values of a reading."""
        return 3 * self.max_peers


@dataclass(frozen=True, kw_only=True)
class WheelSpeedParameters:
    """Wheel encoders: wheel linear speeds [m/s] in the order of `motors`.

    Attributes:
        motors: Names of the motors in the robot's model.
        wheel_radius: Wheel radius [m].
        signs: Sign of each motor, -1 for a motor that is mounted in reverse; all 1 by default.
    """

    motors: tuple[str, ...]
    wheel_radius: Metres
    signs: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        _check_motors(self.motors, self.signs, self.wheel_radius)

    @property
    def size(self) -> int:
        """Number of values of a reading or command."""
        return len(self.motors)

    @property
    def factors(self) -> list[float]:
        """Signed wheel radius of each motor [m]: wheel linear speed per angular speed of the motor."""
        return [s * self.wheel_radius for s in self.signs or (1,) * len(self.motors)]


@dataclass(frozen=True, kw_only=True)
class WheelTravelParameters(WheelSpeedParameters):
    """Incremental encoders: wheel travel since the start [m], in whole counts, in the order of `motors`.

    Attributes:
        counts: Encoder counts per wheel revolution.
    """

    counts: int

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.counts < 1:
            raise InputError(Fault(f"counts must be at least 1 for a revolution of the wheel, found {self.counts}."))

    def travel(self, angles: Sequence[float]) -> list[float]:
        """Wheel travel [m] in whole counts, from motor angles [rad]."""
        each = math.tau / self.counts
        return [math.floor(a / each) * each * factor for a, factor in zip(angles, self.factors, strict=True)]


@dataclass(frozen=True, kw_only=True)
class GyroParameters:
    """Gyro: mean yaw rate since the previous reading [rad/s], left positive.

    Attributes:
        bias_noise: Standard deviation from which the constant bias is sampled [rad/s].
    """

    size: ClassVar[int] = 1
    bias_noise: RadiansPerSecond = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.bias_noise < math.inf:
            raise InputError(Fault(f"bias_noise must be 0 or more and finite, found {self.bias_noise} rad/s."))


@dataclass(frozen=True, kw_only=True)
class VelocityParameters(WheelSpeedParameters):
    """Speed-controlled motors, commanded by wheel linear speeds [m/s] in the order of `motors`.

    Attributes:
        max_acceleration: Acceleration limit of the motor controllers, as linear acceleration of the wheels [m/s2].
        delay: Delay until a command takes effect [s]; a whole number of physics steps.
        slip: Share of the commanded travel that each wheel loses by slip, in the order of `motors`, or one share for
            all wheels; encoders do not see it.
    """

    max_acceleration: MetresPerSecondSquared = math.inf
    delay: Seconds = 0.0
    slip: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.slip) not in (0, 1, self.size) or not all(0.0 <= share < 1.0 for share in self.slip):
            message = f"slip must be one share for all wheels or one for each of {self.size}, at least 0 and below 1"
            raise InputError(Fault(f"{message}, found {list(self.slip)}."))
        if not 0.0 <= self.delay <= 10.0:
            raise InputError(Fault(f"delay must be 0 to 10 s, found {self.delay} s."))
        if not self.max_acceleration > 0.0:
            raise InputError(Fault(f"max_acceleration must be positive, found {self.max_acceleration} m/s2."))


@dataclass(frozen=True, kw_only=True)
class BatteryParameters:
    """Battery: charge, 0 (empty) to 1 (full). An empty battery does not stop the motors.

    Attributes:
        capacity: Energy of the full battery [J].
        idle_power: Power that is always drawn [W].
        motion_power: Power that is drawn in addition while the body moves [W].
        charge_power: Power with which the battery is charged at a charger [W].
        chargers: Names of the places of a scenario at which the battery is charged; other names have no effect.
        charge_distance: Distance between the robot's base and a charger within which the battery is charged [m].
        charge: Charge at the start, 0 to 1.
    """

    size: ClassVar[int] = 1
    capacity: Joules
    idle_power: Watts
    motion_power: Watts = 0.0
    charge_power: Watts = 0.0
    chargers: tuple[str, ...] = ("charger",)
    charge_distance: Metres = 0.3
    charge: float = 1.0

    def __post_init__(self) -> None:
        for name in ("capacity", "charge_distance"):
            if not 0.0 < (value := getattr(self, name)) < math.inf:
                raise InputError(Fault(f"{name} must be positive, found {value}."))
        for name in ("idle_power", "motion_power", "charge_power"):
            if not 0.0 <= (value := getattr(self, name)) < math.inf:
                raise InputError(Fault(f"{name} must be 0 W or more, found {value} W."))
        if not 0.0 <= self.charge <= 1.0:
            raise InputError(Fault(f"charge must be 0 to 1, found {self.charge}."))


@dataclass(frozen=True, kw_only=True)
class MailboxParameters:
    """Mailbox: messages of other robots, as the bytes of sender and text; a reading is empty without messages."""

    size: ClassVar[int | None] = None


DRIVER_PARAMETERS: Mapping[str, type] = {
    "position": PositionParameters,
    "orientation": OrientationParameters,
    "twist": TwistParameters,
    "attitude": AttitudeParameters,
    "height": HeightParameters,
    "range_cone": RangeConeParameters,
    "lidar": LidarParameters,
    "robot_sensor": RobotSensorParameters,
    "wheel_speed": WheelSpeedParameters,
    "wheel_travel": WheelTravelParameters,
    "gyro": GyroParameters,
    "battery": BatteryParameters,
    "mailbox": MailboxParameters,
    "velocity": VelocityParameters,
}
"""Parameters of the drivers in simulation, by name."""

ROS2 = "ros2"
"""Driver of sensors and actuators on hardware that communicate by ROS 2."""


def declared_parameters(driver: str, kind: str) -> type | None:
    """Parameters of a shipped driver; None if no driver has this name.

    Args:
        driver: Name of the driver.
        kind: `sensor` or `actuator`; drivers of packages may have both.
    """
    if driver in registered("rocs_bt.devices"):
        found: type | None = load("rocs_bt.devices", driver).keys.get(kind)
        return found
    return DRIVER_PARAMETERS.get(driver)


def read_parameters(declared: type[T], values: Mapping[str, Any], what: str, *, among: bool = False) -> T:
    """Create the parameters of a driver from the values in robot.toml.

    Args:
        declared: Dataclass of the driver.
        values: Values by name, SI units: floats, integers, texts, or lists of these.
        what: Driver and device, for messages, such as `gyro 'imu'`.
        among: Whether `values` may contain other keys, such as those of a user's driver that extends a shipped one.

    Raises:
        InputError: Parameters are unknown, missing or wrong; the error lists all faults.
    """
    specs = field_parameters(declared)
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
        raise InputError(Fault(f"signs must be 1 or -1 for each of {len(motors)} motors, found {list(signs)}."))
    if not wheel_radius > 0.0:
        raise InputError(Fault(f"wheel_radius must be positive, found {wheel_radius} m."))


def _check_error(odometry: float, drift: float, jump: float, jump_every: float) -> None:
    if not 0.0 <= odometry <= 1.0:
        raise InputError(Fault(f"odometry must be a share, 0 to 1, found {odometry:g}."))
    if not (0.0 <= drift < math.inf and 0.0 <= jump < math.inf):
        raise InputError(Fault(f"drift and jump must be 0 or more and finite, found {drift:g} and {jump:g}."))
    if not jump_every > 0.0:
        raise InputError(Fault(f"jump_every must be positive, found {jump_every:g} s."))


def _check_missing_echo(share: float) -> None:
    if not 0.0 <= share <= 1.0:
        raise InputError(Fault(f"missing_echo must be a probability, 0 to 1, found {share:g}."))


def _check_distinct(what: str, names: tuple[str, ...]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(Fault(f"{what} must name each element of the model once, found {', '.join(twice)} twice."))


def driver_class(drivers: Mapping[str, type[T]], driver: str | type[T], kind: str, backend: str) -> type[T]:
    """Find the class of a driver.

    Args:
        drivers: Driver classes of the backend, by name.
        driver: Name of the driver in robot.toml; or a user's class, which is returned.
        kind: `sensor` or `actuator`, for messages.
        backend: Name of the backend, for messages.

    Raises:
        UnknownName: The backend has no such driver; the error lists its drivers.
    """
    if isinstance(driver, type):
        return driver
    if driver not in drivers:
        raise UnknownName(unknown(f"{kind} driver", driver, drivers, f"The {backend} backend"))
    return drivers[driver]
