"""Mock backend: ideal robots without dynamics, in a world of line segments and circles.

world = MockWorld(clock, segments=[((2, -1), (2, 1))])
robot = MockRobot(world, make_locomotion("differential", ...), Pose2(0, 0, 0), mounts={"front": Pose2(0.2, 0, 0)})
sonar = make_sensor(robot, "sonar", "range_cone", {"sites": ["front"], "range": [0.1, 1.0]})
wheels = make_actuator(robot, "wheels", "velocity", {"motors": ["l", "r"], "wheel_radius": 0.1})
wheels.command([0.3, 0.3])
world.advance(0.05)
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from ..base.clock import Clock
from ..base.errors import DeviceError, Fault, InputError, unknown
from ..base.geometry import Pose2, along_arc
from ..control.locomotion import Locomotion
from ..declare import checked
from ..interfaces.device import Actuator, Reading, Sensor
from ..interfaces.message import MessageQueue, packed
from ..interfaces.safety import SafetyGate
from .common import BatteryModel, GyroModel, RobotSensorModel, TwistModel
from .parameters import (
    DRIVER_PARAMETERS,
    BatteryParameters,
    GyroParameters,
    LidarParameters,
    RangeConeParameters,
    RobotSensorParameters,
    TwistParameters,
    VelocityParameters,
    WheelTravelParameters,
    driver_class,
)

Point: TypeAlias = tuple[float, float]


class MockWorld:
    """World of mock robots.

    Args:
        clock: Clock of the world; the caller of `advance` must also advance the clock.
        segments: Walls, each as its two end points, world frame [m].
        circles: Round obstacles, each as centre, world frame [m], and radius [m].
        places: Positions of places by name, world frame; batteries are charged at some of them.
    """

    def __init__(
        self,
        clock: Clock,
        segments: Sequence[tuple[Point, Point]] = (),
        circles: Sequence[tuple[Point, float]] = (),
        places: Mapping[str, Pose2] | None = None,
    ) -> None:
        self.clock = clock
        self.segments = list(segments)
        self.circles = list(circles)
        self.places = dict(places or {})
        self.robots: list[MockRobot] = []

    def advance(self, duration: float) -> None:
        """Move every robot for a duration [s]. Robots do not collide, and only a robot_sensor detects them."""
        for robot in self.robots:
            robot.advance(duration)

    def ray(self, x: float, y: float, yaw: float) -> float:
        """Distance along a ray to the nearest obstacle [m]; +inf without a hit.

        Args:
            x: Origin, world frame [m].
            y: Origin, world frame [m].
            yaw: Direction, world frame [rad].
        """
        c, s = math.cos(yaw), math.sin(yaw)
        hits = [_hit_segment(x, y, c, s, *seg) for seg in self.segments]
        hits += [_hit_circle(x, y, c, s, *circle) for circle in self.circles]
        return min(hits, default=math.inf)


class MockRobot:
    """Ideal robot without dynamics: the body takes a command immediately, and moves by the kinematics exactly."""

    def __init__(
        self, world: MockWorld, locomotion: Locomotion, pose: Pose2, mounts: Mapping[str, Pose2] | None = None
    ) -> None:
        self.world = world
        self.locomotion = locomotion
        self.pose = pose
        self.mounts = dict(mounts or {})
        self.motion = list(locomotion.rest)  # values of the last command
        self.wheel_travel = [0.0] * len(locomotion.wheels)  # [m]
        self.gates: list[SafetyGate] = []
        world.robots.append(self)

    def advance(self, duration: float) -> None:
        """Move the robot for a duration [s], along an exact arc."""
        for gate in self.gates:
            gate.check()
        self.pose = along_arc(self.pose, self.locomotion.twist(np.array(self.motion)), duration)
        travelled = zip(self.wheel_travel, self.motion, strict=False)
        self.wheel_travel = [travel + speed * duration for travel, speed in travelled]


class MockSensor(Sensor):
    """Base class of mock sensors; an instance of it returns `values`.

    Attributes:
        values: Fixed values, SI units, for tests; None for those that the sensor computes.
        broken: Reason of a simulated failure; None while the sensor works.
    """

    def __init__(
        self, name: str, robot: MockRobot, parameters: Any = None, values: Sequence[float] | None = None
    ) -> None:
        super().__init__(name)
        self.robot = robot
        self.parameters = parameters
        self.values: Sequence[float] | None = None
        self.broken: str | None = None
        self.noise = 0.0
        self.rng = np.random.default_rng(0)

    def sample(self) -> list[float]:
        """Compute the values of a reading, SI units, without noise."""
        return []

    def read(self) -> Reading:
        if self.broken is not None:
            raise DeviceError(f"sensor '{self.name}' has no reading: {self.broken}.")
        values = list(self.sample() if self.values is None else self.values)
        if self.noise > 0.0:
            values = [v + e for v, e in zip(values, self.rng.normal(0.0, self.noise, len(values)), strict=True)]
        return Reading(self.robot.world.clock.now(), values)


class MockPosition(MockSensor):
    """Position sensor: x, y, z of the robot [m], world frame; z is 0."""

    def sample(self) -> list[float]:
        return [self.robot.pose.x, self.robot.pose.y, 0.0]


class MockOrientation(MockSensor):
    """Orientation sensor: yaw of the robot [rad], world frame."""

    def sample(self) -> list[float]:
        return [self.robot.pose.yaw]


class MockTwist(MockSensor):
    """Twist sensor: velocity of the commanded motion, with noise."""

    parameters: TwistParameters
    _model: TwistModel | None = None

    def sample(self) -> list[float]:
        if self._model is None:  # constructed late, since `make_sensor` sets `rng` after the constructor
            self._model = TwistModel(self.parameters, self.rng)
        return self._model.read(self.robot.world.clock.now(), self.robot.locomotion.twist3(self.robot.motion))


class MockAttitude(MockSensor):
    """Attitude sensor: roll and pitch [rad], which are 0."""

    def sample(self) -> list[float]:
        return [0.0, 0.0]


class MockHeight(MockSensor):
    """Height sensor: height [m], which is 0."""

    def sample(self) -> list[float]:
        return [0.0]


class MockWheelSpeed(MockSensor):
    """Wheel encoders: the commanded wheel linear speeds [m/s]."""

    def sample(self) -> list[float]:
        return list(self.robot.motion)


class MockWheelTravel(MockSensor):
    """Incremental encoders: wheel travel since the start [m], in whole counts."""

    parameters: WheelTravelParameters

    def sample(self) -> list[float]:
        given = self.parameters
        pairs = zip(self.robot.wheel_travel, given.factors, strict=True)
        return given.travel([travel / factor for travel, factor in pairs])


class MockGyro(MockSensor):
    """Gyro: mean yaw rate since the previous reading [rad/s]."""

    parameters: GyroParameters
    _model: GyroModel | None = None

    def sample(self) -> list[float]:
        if self._model is None:  # constructed late, since `make_sensor` sets `rng` after the constructor
            self._model = GyroModel(self.parameters, self.rng)
        return [self._model.read(self.robot.world.clock.now(), self.robot.pose.yaw)]


class MockRangeCone(MockSensor):
    """Range sensors with conical beams [m], with the same fans of rays as in MuJoCo."""

    def __init__(self, name: str, robot: MockRobot, parameters: RangeConeParameters) -> None:
        super().__init__(name, robot, parameters)
        missing = [s for s in parameters.sites if s not in robot.mounts]
        if missing:
            raise InputError(*(unknown(f"mount for sensor '{name}'", s, robot.mounts, "The robot") for s in missing))

    def sample(self) -> list[float]:
        low, high = self.parameters.range
        found = []
        for site in self.parameters.sites:
            x, y, yaw = self.robot.pose.compose(self.robot.mounts[site])
            nearest = min(self.robot.world.ray(x, y, yaw + left) for left, _ in self.parameters.angles)
            found.append(math.inf if nearest > high else max(nearest, low))
        return found


class MockLidar(MockSensor):
    """Laser scanner: ranges [m] along rays from the mounting position."""

    def __init__(self, name: str, robot: MockRobot, parameters: LidarParameters) -> None:
        super().__init__(name, robot, parameters)
        if parameters.site not in robot.mounts:
            raise InputError(unknown(f"mount for sensor '{name}'", parameters.site, robot.mounts, "The robot"))

    def sample(self) -> list[float]:
        low, high = self.parameters.range
        x, y, yaw = self.robot.pose.compose(self.robot.mounts[self.parameters.site])
        found = [self.robot.world.ray(x, y, yaw + bearing) for bearing in self.parameters.bearings]
        return [math.inf if distance > high else max(distance, low) for distance in found]


class MockRobotSensor(MockSensor):
    """Robot sensor: tags, ranges [m] and bearings [rad] of the other robots that no segment or circle hides."""

    def __init__(self, name: str, robot: MockRobot, parameters: RobotSensorParameters) -> None:
        super().__init__(name, robot, parameters)
        self._model: RobotSensorModel | None = None

    def sample(self) -> list[float]:
        world, here = self.robot.world, self.robot.pose
        peers = {tag: other.pose for tag, other in enumerate(world.robots, 1) if other is not self.robot}
        if self._model is None:  # constructed late, since `make_sensor` sets `rng` after the constructor
            self._model = RobotSensorModel(self.parameters, self.rng)

        def seen(tag: int) -> bool:
            away = peers[tag].x - here.x, peers[tag].y - here.y
            return world.ray(here.x, here.y, math.atan2(away[1], away[0])) >= math.hypot(*away)

        return self._model.read(world.clock.now(), here, peers, seen)


class MockWheels(Actuator):
    """Wheels that reach their commanded speed immediately."""

    def __init__(self, name: str, robot: MockRobot, parameters: VelocityParameters) -> None:
        super().__init__(name, len(robot.locomotion.wheels))
        self._robot = robot
        if len(parameters.motors) != self.size:
            raise InputError(
                Fault(f"actuator '{name}' has {len(parameters.motors)} motors, the robot's drive {self.size} wheels.")
            )

    def command(self, values: Sequence[float]) -> None:
        if len(values) != self.size:
            raise DeviceError(f"actuator '{self.name}' takes {self.size} wheel speeds, found {len(values)}.")
        self._robot.motion = [float(v) for v in values]

    def neutral(self) -> None:
        self._robot.motion = [0.0] * self.size


class MockMailbox(MockSensor):
    """Mailbox: messages of other robots since the last reading."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.message_queue = MessageQueue()

    def sample(self) -> list[float]:
        return packed(self.message_queue.take())


class MockBattery(MockSensor):
    """Battery: charge, 0 to 1."""

    def __init__(self, name: str, robot: MockRobot, parameters: BatteryParameters) -> None:
        super().__init__(name, robot, parameters)
        self._model = BatteryModel(parameters, robot.world.clock.now(), robot.world.places)

    def sample(self) -> list[float]:
        robot = self.robot
        return self._model.read(robot.world.clock.now(), robot.pose, robot.locomotion.twist3(robot.motion))


SENSORS: Mapping[str, type[MockSensor]] = {
    "position": MockPosition,
    "orientation": MockOrientation,
    "twist": MockTwist,
    "attitude": MockAttitude,
    "height": MockHeight,
    "wheel_speed": MockWheelSpeed,
    "wheel_travel": MockWheelTravel,
    "gyro": MockGyro,
    "range_cone": MockRangeCone,
    "lidar": MockLidar,
    "robot_sensor": MockRobotSensor,
    "battery": MockBattery,
    "mailbox": MockMailbox,
}
ACTUATORS: Mapping[str, type[MockWheels]] = {"velocity": MockWheels}


def make_sensor(
    robot: MockRobot,
    name: str,
    driver: str,
    parameters: Mapping[str, Any],
    *,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
) -> MockSensor:
    """Construct a sensor of a mock robot, from the parameters that the MuJoCo backend also takes.

    Args:
        robot: Robot of the sensor.
        name: Name of the sensor in robot.toml.
        driver: Name of the driver.
        parameters: Parameters of the driver, SI units.
        noise: Standard deviation of each value, SI units.
        rng: Random generator of the noise; by default one with a fixed seed.

    Raises:
        InputError: The driver is unknown, or parameters are wrong.
    """
    cls = driver_class(SENSORS, driver, "sensor", "mock")
    sensor = cls(name, robot, checked(DRIVER_PARAMETERS[driver], parameters, f"{driver} sensor '{name}'"))
    sensor.noise = noise
    sensor.rng = sensor.rng if rng is None else rng
    return sensor


def make_actuator(robot: MockRobot, name: str, driver: str, parameters: Mapping[str, Any]) -> MockWheels:
    """Construct an actuator of a mock robot.

    Args:
        robot: Robot of the actuator.
        name: Name of the actuator in robot.toml.
        driver: Name of the driver.
        parameters: Parameters of the driver, SI units.

    Raises:
        InputError: The driver is unknown, parameters are wrong, or there is not one motor for each wheel of the drive.
    """
    cls = driver_class(ACTUATORS, driver, "actuator", "mock")
    return cls(name, robot, checked(VelocityParameters, parameters, f"{driver} actuator '{name}'"))


def _hit_segment(x: float, y: float, c: float, s: float, a: Point, b: Point) -> float:
    ex, ey = b[0] - a[0], b[1] - a[1]
    cross = c * ey - s * ex
    if cross == 0.0:
        return math.inf
    dx, dy = a[0] - x, a[1] - y
    along, share = (dx * ey - dy * ex) / cross, (dx * s - dy * c) / cross
    return along if along >= 0.0 and 0.0 <= share <= 1.0 else math.inf


def _hit_circle(x: float, y: float, c: float, s: float, centre: Point, radius: float) -> float:
    dx, dy = centre[0] - x, centre[1] - y
    along = dx * c + dy * s
    across = dx * dx + dy * dy - along * along
    if across > radius * radius:
        return math.inf
    half = math.sqrt(radius * radius - across)
    if along - half >= 0.0:
        return along - half
    return 0.0 if along + half >= 0.0 else math.inf
