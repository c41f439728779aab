"""Parameters of drivers: the keys of each shipped driver in robot.toml, which are the same in all backends.

They are declared classes (`rocs_bt.declare`). The keys of a user's driver are the keyword-only parameters of its
constructor; annotations declare the units:

    class Beacon(MujocoSensor):
        def __init__(self, name, mount, *, max_range: Metres = 10.0):
            super().__init__(name, mount)
            self.max_range = max_range
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, ClassVar, TypeVar

from ..base.errors import UnknownName, unknown
from ..base.registered import load, registered
from ..base.units import (
    ACCELERATION,
    ANGLE,
    LENGTH,
    NONE,
    NOT_NEGATIVE,
    POSITIVE,
    TIME,
    Bounds,
    Joules,
    MetresPerSecond,
    PositiveMetres,
    Radians,
    RadiansPerSecond,
    Watts,
)
from ..declare import Value, Wrong

T = TypeVar("T")

_UNLIMITED = Bounds(0.0, infinite=True)
_Share = Annotated[float, NONE, Bounds(0.0, 1.0)]
_Distance = Annotated[float, LENGTH, NOT_NEGATIVE]
_Noise = Annotated[Radians, NOT_NEGATIVE]
_TurnNoise = Annotated[RadiansPerSecond, NOT_NEGATIVE]
_Interval = Annotated[float, TIME, Bounds(0.0, above=True, infinite=True)]
_Power = Annotated[Watts, NOT_NEGATIVE]

MAX_SIZE = 1000
"""Maximum number of rays per beam, or of slots, of a sensor, so that a typing error cannot stall the machine."""

_Count = Annotated[int, Bounds(1, MAX_SIZE)]

MAX_LIDAR_RAYS = 4000
"""Maximum number of rays in a scan of a lidar."""

MAX_SWEEP = 1.0
"""Maximum sweep of a scan of a lidar [s]."""


class PositionParameters(Value):
    """Position sensor: x, y, z of the base [m], world frame.

    Attributes:
        odometry: Relative error of an odometer that replaces the true pose; 0 for the true pose.
        drift: Standard deviation of the change of the error of x and of y in a second, a random walk [m].
        jump: Standard deviation of the error of x and of y that is sampled again at each jump [m].
        jump_every: Mean time between two jumps [s]; they come at random.
    """

    size: ClassVar[int] = 3
    odometry: _Share = 0.0
    drift: _Distance = 0.0
    jump: _Distance = 0.0
    jump_every: _Interval = 10.0


class OrientationParameters(Value):
    """Orientation sensor: yaw of the base [rad], world frame.

    Attributes:
        odometry: Relative error of an odometer, as of a position sensor.
        drift: Standard deviation of the change of the error in a second, a random walk [rad].
        jump: Standard deviation of the error that is sampled again at each jump [rad].
        jump_every: Mean time between two jumps [s]; they come at random.
    """

    size: ClassVar[int] = 1
    odometry: _Share = 0.0
    drift: _Noise = 0.0
    jump: _Noise = 0.0
    jump_every: _Interval = 10.0


class TwistParameters(Value):
    """Twist sensor: velocity of the base, forward, left and up [m/s], and turn rate, left positive [rad/s].

    Forward and left are horizontal, up and the axis of the turn are vertical, also while the body tilts.

    Attributes:
        speed_noise: Standard deviation of each speed [m/s].
        turn_noise: Standard deviation of the turn rate [rad/s].
    """

    size: ClassVar[int] = 4
    speed_noise: Annotated[MetresPerSecond, NOT_NEGATIVE] = 0.0
    turn_noise: _TurnNoise = 0.0


class AttitudeParameters(Value):
    """Attitude sensor: roll and pitch of the base [rad], as in `Pose3`."""

    size: ClassVar[int] = 2


class HeightParameters(Value):
    """Height sensor: height of the base [m], world frame."""

    size: ClassVar[int] = 1


class RangeConeParameters(Value):
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
    range: tuple[_Distance, Annotated[float, LENGTH, _UNLIMITED]]
    half_angle: Annotated[float, ANGLE, Bounds(0.0, math.pi / 2, below=True)] = 0.0
    rays: _Count = 1
    layers: _Count = 1
    missing_echo: _Share = 0.0

    def _check(self) -> Iterator[Wrong]:
        """Faults of the names of sites, and of a range that is none."""
        yield from _listed("sites", "site", self.sites)
        yield from _span(self.range)

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


class LidarParameters(Value):
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
    rays: Annotated[int, Bounds(2, MAX_LIDAR_RAYS)]
    span: Annotated[float, ANGLE, Bounds(0.0, math.tau, above=True)]
    range: tuple[_Distance, _Distance]
    missing_echo: _Share = 0.0
    sweep: Annotated[float, TIME, Bounds(0.0, MAX_SWEEP)] = 0.0

    def _check(self) -> Iterator[Wrong]:
        """Faults of a range that is none."""
        yield from _span(self.range)

    @property
    def size(self) -> int:
        """Number of values of a reading."""
        return self.rays

    @property
    def bearings(self) -> list[float]:
        """Directions of the rays, sensor frame, left positive [rad]."""
        return [self.span * (i / (self.rays - 1) - 0.5) for i in range(self.rays)]


class RobotSensorParameters(Value):
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

    max_range: Annotated[float, LENGTH, Bounds(0.0, above=True, infinite=True)]
    max_peers: _Count = 4
    half_angle: Annotated[float, ANGLE, Bounds(0.0, math.pi, above=True)] = math.pi
    range_noise: _Distance = 0.0
    bearing_noise: _Noise = 0.0
    height: PositiveMetres = 0.2

    @property
    def size(self) -> int:
        """Number of values of a reading."""
        return 3 * self.max_peers


class WheelSpeedParameters(Value):
    """Wheel encoders: wheel linear speeds [m/s] in the order of `motors`.

    Attributes:
        motors: Names of the motors in the robot's model.
        wheel_radius: Wheel radius [m].
        signs: Sign of each motor, -1 for a motor that is mounted in reverse; all 1 by default.
    """

    motors: tuple[str, ...]
    wheel_radius: PositiveMetres
    signs: tuple[int, ...] = ()

    def _check(self) -> Iterator[Wrong]:
        """Faults of the names of motors, and of signs that are none."""
        yield from _listed("motors", "motor", self.motors)
        if self.signs and (len(self.signs) != self.size or any(sign not in (-1, 1) for sign in self.signs)):
            message = f"signs must be 1 or -1 for each of {self.size} motors, found {list(self.signs)}."
            yield Wrong("signs", message)

    @property
    def size(self) -> int:
        """Number of values of a reading or command."""
        return len(self.motors)

    @property
    def factors(self) -> list[float]:
        """Signed wheel radius of each motor [m]: wheel linear speed per angular speed of the motor."""
        return [s * self.wheel_radius for s in self.signs or (1,) * len(self.motors)]


class WheelTravelParameters(WheelSpeedParameters):
    """Incremental encoders: wheel travel since the start [m], in whole counts, in the order of `motors`.

    Attributes:
        counts: Encoder counts per wheel revolution.
    """

    counts: Annotated[int, Bounds(1)]

    def travel(self, angles: Sequence[float]) -> list[float]:
        """Wheel travel [m] in whole counts, from motor angles [rad]."""
        each = math.tau / self.counts
        return [math.floor(a / each) * each * factor for a, factor in zip(angles, self.factors, strict=True)]


class GyroParameters(Value):
    """Gyro: mean yaw rate since the previous reading [rad/s], left positive.

    Attributes:
        bias_noise: Standard deviation from which the constant bias is sampled [rad/s].
    """

    size: ClassVar[int] = 1
    bias_noise: _TurnNoise = 0.0


class VelocityParameters(WheelSpeedParameters):
    """Speed-controlled motors, commanded by wheel linear speeds [m/s] in the order of `motors`.

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


class BatteryParameters(Value):
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
    capacity: Annotated[Joules, POSITIVE]
    idle_power: _Power
    motion_power: _Power = 0.0
    charge_power: _Power = 0.0
    chargers: tuple[str, ...] = ("charger",)
    charge_distance: PositiveMetres = 0.3
    charge: _Share = 1.0


class MailboxParameters(Value):
    """Mailbox: messages of other robots, as the bytes of sender and text; a reading is empty without messages."""

    size: ClassVar[int | None] = None


DRIVER_PARAMETERS: Mapping[str, type[Value]] = {
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


def declared_parameters(driver: str, kind: str) -> type[Value] | None:
    """Parameters of a shipped driver; None if no driver has this name.

    Args:
        driver: Name of the driver.
        kind: `sensor` or `actuator`; drivers of packages may have both.
    """
    if driver in registered("rocs_bt.devices"):
        found: type[Value] | None = load("rocs_bt.devices", driver).keys.get(kind)
        return found
    return DRIVER_PARAMETERS.get(driver)


def _listed(key: str, what: str, names: tuple[str, ...]) -> Iterator[Wrong]:
    """Faults of names of elements of the model, of which a device needs at least one."""
    if not names:
        yield Wrong(key, f"{key} must name at least one {what} of the model, found none.")
    if twice := sorted({name for name in names if names.count(name) > 1}):
        yield Wrong(key, f"{key} must name each element of the model once, found {', '.join(twice)} twice.")


def _span(found: tuple[float, float]) -> Iterator[Wrong]:
    """Fault of a range of distances of which the maximum is not above the minimum."""
    if not found[0] < found[1]:
        yield Wrong("range", f"range must be the minimum and the maximum distance, found {list(found)} m.")


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
