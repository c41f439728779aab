"""Sensor drivers of the MuJoCo backend; values are computed when a sensor is read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...base.errors import InputError, unknown
from ...base.geometry import Pose2, wrap_angle
from ...declare import checked
from ...interfaces.message import MessageQueue, packed
from ...record.header import Beam
from ..common import BatteryModel, GyroModel, PoseError, RobotSensorModel, TwistModel
from ..parameters import (
    AttitudeParameters,
    BatteryParameters,
    GyroParameters,
    HeightParameters,
    MailboxParameters,
    OrientationParameters,
    PositionParameters,
    RangeConeParameters,
    RobotSensorParameters,
    TwistParameters,
    WheelSpeedParameters,
    WheelTravelParameters,
    driver_class,
)
from .lidar import Lidar
from .mount import Mount
from .sensor import MujocoSensor

if TYPE_CHECKING:
    from .odometer import Odometer
    from .world import MujocoWorld


class PoseSensor(MujocoSensor):
    """Base class of sensors of the pose, with their errors.

    Attributes:
        given: Parameters.
        odometer: Odometer that replaces the true pose; None for the true pose. All sensors of a robot share one.
    """

    def __init__(self, name: str, mount: Mount, given: PositionParameters | OrientationParameters, errors: int) -> None:
        super().__init__(name, mount)
        self.given = given
        self.odometer: Odometer | None = None
        self._error = PoseError(given, errors, mount.faults_rng()) if given.drift or given.jump else None

    @property
    def exact(self) -> bool:
        """Whether the readings are ground truth."""
        return self._error is None and not self.mount.noise and not self.given.odometry

    def pose(self) -> Pose2:
        """Pose of the base, true or of the odometer."""
        return self.mount.world.pose(self.mount.robot) if self.odometer is None else self.odometer.pose()


class Position(PoseSensor):
    """Position sensor: x, y, z of the base [m], world frame."""

    declares = PositionParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        given = checked(PositionParameters, parameters, f"position sensor '{name}'")
        super().__init__(name, mount, given, 2)

    def sample(self) -> list[float]:
        found = self.mount.world.position(self.mount.robot)
        if self.odometer is not None:
            found[:2] = self.pose()[:2]
        if self._error is None:
            return found
        x, y = self._error.at(self.mount.world.stamp)
        return [found[0] + x, found[1] + y, found[2]]


class Orientation(PoseSensor):
    """Orientation sensor: yaw of the base [rad], world frame."""

    declares = OrientationParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        given = checked(OrientationParameters, parameters, f"orientation sensor '{name}'")
        super().__init__(name, mount, given, 1)

    def sample(self) -> list[float]:
        yaw = self.pose().yaw
        return [yaw if self._error is None else wrap_angle(yaw + self._error.at(self.mount.world.stamp)[0])]


class TwistSensor(MujocoSensor):
    """Twist sensor: true velocity of the base, forward, left, up [m/s] and turn [rad/s], with noise."""

    declares = TwistParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        self._model = TwistModel(checked(TwistParameters, parameters, f"twist sensor '{name}'"), mount.rng)
        if mount.noise > 0.0:
            raise InputError(f"twist sensor '{name}' does not take 'noise'. Use speed_noise and turn_noise.")

    def sample(self) -> list[float]:
        world = self.mount.world
        return self._model.read(world.stamp, world.twist3(self.mount.robot))


class Attitude(MujocoSensor):
    """Attitude sensor: roll and pitch of the base [rad]."""

    declares = AttitudeParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        checked(AttitudeParameters, parameters, f"attitude sensor '{name}'")

    def sample(self) -> list[float]:
        pose = self.mount.world.pose3(self.mount.robot)
        return [pose.roll, pose.pitch]


class Height(MujocoSensor):
    """Height sensor: height of the base [m], world frame."""

    declares = HeightParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        checked(HeightParameters, parameters, f"height sensor '{name}'")

    def sample(self) -> list[float]:
        return self.mount.world.position(self.mount.robot)[2:]


class WheelSpeed(MujocoSensor):
    """Wheel encoders: wheel linear speeds [m/s], measured at the motor shafts."""

    declares = WheelSpeedParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        self.parameters = checked(WheelSpeedParameters, parameters, f"wheel_speed sensor '{name}'")
        self.motors = mount.world.motors(mount.robot, self.parameters.motors)
        self._factors = self.parameters.factors

    def sample(self) -> list[float]:
        speeds = self.mount.world.motor_speeds(self.motors)
        return [s * f for s, f in zip(speeds, self._factors, strict=True)]


class WheelTravel(MujocoSensor):
    """Incremental encoders: wheel travel [m] in whole counts, measured at the motor shafts, so it includes slip."""

    declares = WheelTravelParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        self.parameters = checked(WheelTravelParameters, parameters, f"wheel_travel sensor '{name}'")
        self.motors = mount.world.motors(mount.robot, self.parameters.motors)

    def sample(self) -> list[float]:
        return self.parameters.travel(self.mount.world.motor_angles(self.motors))


class Gyro(MujocoSensor):
    """Gyro: mean yaw rate since the previous reading [rad/s]."""

    declares = GyroParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        self.parameters = checked(GyroParameters, parameters, f"gyro '{name}'")
        self._model = GyroModel(self.parameters, mount.rng)

    def sample(self) -> list[float]:
        world = self.mount.world
        return [self._model.read(world.stamp, world.pose(self.mount.robot).yaw)]


class RangeCone(MujocoSensor):
    """Range sensors with conical beams: each range [m] is the minimum over a fan of MuJoCo rangefinder rays."""

    declares = RangeConeParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        self.parameters = _cones(parameters, name)
        addresses = [
            mount.world.sensor_address(mount.robot, f"{name}/{site}/{ray}")
            for site in self.parameters.sites
            for ray in range(len(self.parameters.angles))
        ]
        self._addresses = np.array(addresses, dtype=np.intp)
        self._heard: tuple[float, npt.NDArray[np.bool_]] = (math.nan, np.ones(self.parameters.size, bool))
        self._faults_rng = mount.faults_rng()

    @classmethod
    def prepare(cls, model: Any, name: str, parameters: Mapping[str, Any]) -> None:
        from .library import mujoco

        wanted = _cones(parameters, name, among="declares" not in vars(cls))
        _require_sites(model, wanted.sites, name)
        compiled = model.copy().compile()  # resolves every form of orientation in the file
        for site in wanted.sites:
            found = compiled.site(site)
            body = model.body(compiled.body(int(compiled.site_bodyid[found.id])).name)
            axis = _axis(found.quat)
            for ray, (left, up) in enumerate(wanted.angles):
                quat = np.zeros(4)
                mujoco.mju_quatZ2Vec(quat, _ray(axis, left, up))
                label = f"{name}/{site}/{ray}"
                body.add_site(name=label, pos=found.pos, quat=quat, size=[0.001] * 3, group=5)
                model.add_sensor(
                    name=label,
                    type=mujoco.mjtSensor.mjSENS_RANGEFINDER,
                    objtype=mujoco.mjtObj.mjOBJ_SITE,
                    objname=label,
                    intprm=[1, 0, 0],  # distance only
                )

    def sample(self) -> list[float]:
        rays = self.mount.world.sensed(self._addresses)  # -1 where a ray hits nothing
        nearest: list[float] = (
            np.where(rays < 0.0, math.inf, rays).reshape(len(self.parameters.sites), -1).min(axis=1).tolist()
        )
        return nearest

    def limit(self, values: list[float]) -> list[float]:
        low, high = self.parameters.range
        limited = [math.inf if v > high else low if v < low else v for v in values]
        if share := self.parameters.missing_echo:
            if self._heard[0] != (stamp := self.mount.world.stamp):  # a repeated reading at the same time is equal
                self._heard = stamp, self._faults_rng.random(len(limited)) >= share
            limited = [v if heard else math.inf for v, heard in zip(limited, self._heard[1].tolist(), strict=True)]
        return limited

    def beams(self) -> tuple[Beam, ...]:
        """Origins and directions of the beams, body frame, for displays."""
        model, low_high = self.mount.world.model, self.parameters.range
        found = []
        for site in self.parameters.sites:
            element = model.site(f"{self.mount.robot}/{site}")
            axis = _axis(element.quat)
            yaw, elevation = math.atan2(axis[1], axis[0]), math.atan2(axis[2], math.hypot(axis[0], axis[1]))
            x, y = element.pos[:2].tolist()
            cone = 2.0 * self.parameters.half_angle
            found.append(Beam(x=x, y=y, yaw=yaw, reach=low_high[1], cone=cone, elevation=elevation))
        return tuple(found)


class RobotSensor(MujocoSensor):
    """Robot sensor: tags, ranges [m] and bearings [rad] of the other robots that are in its line of sight."""

    declares = RobotSensorParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        self.parameters = checked(RobotSensorParameters, parameters, f"robot_sensor '{name}'")
        if mount.noise > 0.0:
            raise InputError(f"robot_sensor '{name}' does not take 'noise'. Use range_noise and bearing_noise.")
        self._model = RobotSensorModel(self.parameters, mount.rng)
        self._others = {tag: other for tag, other in enumerate(mount.world.robots, 1) if other != mount.robot}

    def sample(self) -> list[float]:
        world, robot, others, height = self.mount.world, self.mount.robot, self._others, self.parameters.height
        peers = {tag: world.pose(other) for tag, other in others.items()}
        return self._model.read(
            world.stamp, world.pose(robot), peers, lambda tag: world.sees(robot, others[tag], height)
        )


class MailboxSensor(MujocoSensor):
    """Mailbox: messages of other robots since the last reading, as on a real robot."""

    declares = MailboxParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        checked(MailboxParameters, parameters, f"mailbox '{name}'")
        self.message_queue = MessageQueue()

    def sample(self) -> list[float]:
        return packed(self.message_queue.take())


class Battery(MujocoSensor):
    """Battery: charge, 0 to 1."""

    declares = BatteryParameters

    def __init__(self, name: str, mount: Mount, **parameters: Any) -> None:
        super().__init__(name, mount)
        given = checked(BatteryParameters, parameters, f"battery '{name}'")
        self._model = BatteryModel(given, mount.world.stamp, mount.world.places)

    def sample(self) -> list[float]:
        world, robot = self.mount.world, self.mount.robot
        return self._model.read(world.stamp, world.pose(robot), world.twist3(robot))

    def limit(self, values: list[float]) -> list[float]:
        return [min(1.0, max(0.0, value)) for value in values]


SENSORS: Mapping[str, type[MujocoSensor]] = {
    "position": Position,
    "orientation": Orientation,
    "twist": TwistSensor,
    "attitude": Attitude,
    "height": Height,
    "wheel_speed": WheelSpeed,
    "wheel_travel": WheelTravel,
    "gyro": Gyro,
    "range_cone": RangeCone,
    "lidar": Lidar,
    "robot_sensor": RobotSensor,
    "battery": Battery,
    "mailbox": MailboxSensor,
}


def make_sensor(
    world: MujocoWorld,
    robot: str,
    name: str,
    driver: str | type[MujocoSensor],
    parameters: Mapping[str, Any],
    *,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
    latency: float = 0.0,
    drop_out: float = 0.0,
) -> MujocoSensor:
    """Construct a sensor of a robot in the world.

    Args:
        world: World that was compiled with this sensor.
        robot: Name of the robot.
        name: Name of the sensor in robot.toml.
        driver: Name of the driver, or a user's class.
        parameters: Parameters of the driver, SI units.
        noise: Standard deviation of each value, SI units.
        rng: Random generator of the noise; by default one with a fixed seed.
        latency: Time until a reading can be read [s].
        drop_out: Probability that a reading is lost.

    Raises:
        InputError: The driver is unknown, or parameters do not fit the driver or the model.
    """
    world.body(robot)
    rng = np.random.default_rng(0) if rng is None else rng
    mount = Mount(world, robot, noise, rng, latency, drop_out)
    return driver_class(SENSORS, driver, "sensor", "mujoco")(name, mount, **parameters)


def _cones(parameters: Mapping[str, Any], name: str, *, among: bool = False) -> RangeConeParameters:
    return checked(RangeConeParameters, parameters, f"range_cone sensor '{name}'", among=among)


def _axis(quat: Any) -> list[float]:
    from .library import mujoco

    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quat)
    axis: list[float] = matrix.reshape(3, 3)[:, 2].tolist()
    return axis


def _ray(axis: Sequence[float], left: float, up: float) -> npt.NDArray[np.float64]:
    """Direction of a ray at angles to the left and up from the axis of its beam, shape (3,)."""
    c, s = math.cos(left), math.sin(left)
    x, y, z = axis
    if math.hypot(x, y) > 1e-6:
        turned = np.array([c * x - s * y, s * x + c * y, z])
        across = np.array([-turned[1], turned[0], 0.0]) / math.hypot(x, y)
    else:  # a vertical beam: its rays spread along the y and x axes of the body
        turned, across = np.array([0.0, s, c * z]), np.array([0.0, c, -s * z])
    return math.cos(up) * turned + math.sin(up) * np.cross(turned, across)


def _require_sites(model: Any, sites: Sequence[str], sensor: str) -> None:
    # Sites that other sensors have added contain a slash in their names; the author's sites do not.
    known = [s.name for s in model.sites if s.name and "/" not in s.name]
    if missing := [site for site in sites if site not in known]:
        raise InputError(*(unknown(f"site for sensor '{sensor}'", site, known, "The model") for site in missing))
