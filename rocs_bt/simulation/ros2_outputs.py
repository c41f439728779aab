"""Topics of a simulated robot: its sensors' readings as standard ROS 2 messages."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, TypeVar

import numpy as np

from ..agent import RobotDevices
from ..clock import Rate
from ..control.locomotion import Locomotion
from ..device import Sensor
from ..drivers.mujoco import DriverWorld
from ..drivers.mujoco.lidar import Lidar
from ..drivers.mujoco.sensors import (
    Gyro,
    MailboxSensor,
    Orientation,
    Position,
    RangeCone,
    WheelSpeed,
    WheelTravel,
)
from ..drivers.ros2 import messages
from ..drivers.ros2.messages import UNMEASURED
from ..drivers.ros2.qos import QoS
from ..geometry import Pose3
from .robot_links import RobotLinks
from .robot_publishers import RobotPublishers, TfPublishers
from .ros_names import BASE, FOOTPRINT, MAP, ODOM
from .wheel_odometry import EXACT, Motion, WheelOdometry

T = TypeVar("T")

STATE = QoS("reliable", "volatile", 10)
"""Quality of service of odometry, joint states and transforms, as robots offer it."""

SENSORS = QoS("reliable", "volatile", 5)
"""Quality of service of scans and other readings, which reliable and best-effort subscriptions can receive."""

_TRUE_POSE = messages.diagonal([EXACT] * 6)
_TRUE_TWIST = messages.diagonal([EXACT, EXACT, EXACT, UNMEASURED, UNMEASURED, EXACT])


class Output(ABC):
    """Publishes the readings of one or more sensors.

    Attributes:
        name: Name of the sensor, or of the topic.
        rate: Rate in control periods.
    """

    def __init__(self, name: str, rate: Rate) -> None:
        self.name = name
        self.rate = rate

    @abstractmethod
    def publish(self) -> None:
        """Read the sensors and publish; a sensor without a sample publishes nothing.

        Raises:
            DeviceError: A sensor has no sample.
        """


class _Scan(Output):
    """Scan of a lidar."""

    def __init__(self, sensor: Lidar, topic: str, rate: Rate, names: RobotPublishers, links: RobotLinks) -> None:
        super().__init__(sensor.name, rate)
        self._sensor, self._frame = sensor, names.frame(sensor.name)
        self._publisher = names.publisher(topic, "sensor_msgs/msg/LaserScan", SENSORS, rate)
        link, pose = links.site(sensor.parameters.site)
        names.fix(names.frame(link), self._frame, pose)

    def publish(self) -> None:
        reading, given = self._sensor.read(), self._sensor.parameters
        first, step = -0.5 * given.span, given.span / (given.rays - 1)
        ranges = np.asarray(reading.values, np.float32)
        self._publisher.send(
            messages.laser_scan(
                reading.stamp,
                self._frame,
                ranges,
                first=first,
                step=step,
                limits=given.range,
                period=self.rate.period,
            )
        )


class _Ranges(Output):
    """Ranges of sensors with conical beams, one topic for each beam."""

    def __init__(self, sensor: RangeCone, rate: Rate, names: RobotPublishers, links: RobotLinks) -> None:
        super().__init__(sensor.name, rate)
        self._sensor = sensor
        self._beams = []
        for site in sensor.parameters.sites:
            publisher = names.publisher(f"range/{site}", "sensor_msgs/msg/Range", SENSORS, rate)
            link, pose = links.site(site)
            names.fix(names.frame(link), names.frame(site), _beam(pose))
            self._beams.append((publisher, names.frame(site)))

    def publish(self) -> None:
        reading, given = self._sensor.read(), self._sensor.parameters
        opening = 2.0 * given.half_angle
        for (publisher, frame), distance in zip(self._beams, reading.values, strict=True):
            publisher.send(messages.sonar_range(reading.stamp, frame, distance, opening=opening, limits=given.range))


class _Imu(Output):
    """Turn rate of a gyro."""

    def __init__(self, sensor: Gyro, topic: str, rate: Rate, names: RobotPublishers, links: RobotLinks) -> None:
        super().__init__(sensor.name, rate)
        self._sensor, self._frame = sensor, names.frame(sensor.name)
        self._publisher = names.publisher(topic, "sensor_msgs/msg/Imu", SENSORS, rate)
        variance = max(sensor.mount.noise**2 + sensor.parameters.bias_noise**2, EXACT)
        self._covariance = messages.diagonal([UNMEASURED, UNMEASURED, variance])
        names.fix(names.frame(BASE), self._frame, Pose3(0.0, 0.0, 0.0))

    def publish(self) -> None:
        reading = self._sensor.read()
        self._publisher.send(messages.imu(reading.stamp, self._frame, reading.values[0], self._covariance))


class _Joints(Output):
    """Angles and speeds of the motors that encoders measure."""

    def __init__(self, sensor: WheelSpeed | WheelTravel, rate: Rate, names: RobotPublishers) -> None:
        super().__init__(sensor.name, rate)
        self._sensor, model = sensor, sensor.mount.world.model
        joints = (model.joint(int(model.dof_jntid[dof])).name for dof in sensor.motors.joints)
        self._names = [str(joint).removeprefix(f"{names.robot}/") for joint in joints]
        self._publisher = names.publisher("joint_states", "sensor_msgs/msg/JointState", STATE, rate)

    def publish(self) -> None:
        sensor, world = self._sensor, self._sensor.mount.world
        reading = sensor.read()
        measured = [v / f for v, f in zip(reading.values, sensor.parameters.factors, strict=True)]
        travel = isinstance(sensor, WheelTravel)
        angles = measured if travel else world.motor_angles(sensor.motors)
        speeds = world.motor_speeds(sensor.motors) if travel else measured
        self._publisher.send(messages.joint_state(reading.stamp, self._names, angles, speeds))


class _Odometry(Output):
    """Odometry of `base_link`, and the transform from `odom` to `base_footprint`, which is below it."""

    def __init__(self, read: Callable[[], Motion], rate: Rate, names: RobotPublishers, height: float) -> None:
        super().__init__("odom", rate)
        self._read, self._height = read, height
        self._publisher = names.publisher("odom", "nav_msgs/msg/Odometry", STATE, rate)
        self._tf = names.tf if names.options.odom_to_base else None
        self._odom, self._footprint, self._base = map(names.frame, (ODOM, FOOTPRINT, BASE))

    def publish(self) -> None:
        stamp, pose, twist, *errors = self._read()
        self._publisher.send(messages.odometry(stamp, self._odom, self._base, pose, twist, errors))
        if self._tf is not None:
            self._tf.send([messages.transform(stamp, self._odom, self._footprint, _below(pose, self._height))])


class _Joined(Output):
    """Transforms of the links on joints."""

    def __init__(self, links: RobotLinks, tf: TfPublishers, rate: Rate, names: RobotPublishers) -> None:
        super().__init__("links", rate)
        self._links, self._tf, self._frame = links, tf, names.frame

    def publish(self) -> None:
        stamp, found = self._links.poses()
        frame = self._frame
        self._tf.send([messages.transform(stamp, frame(parent), frame(link), pose) for parent, link, pose in found])


class _PoseFix(Output):
    """Noisy measurements of the pose in the map."""

    def __init__(self, position: Position, orientation: Orientation, rate: Rate, names: RobotPublishers) -> None:
        super().__init__("pose", rate)
        self._position, self._orientation = position, orientation
        self._publisher = names.publisher("pose", "geometry_msgs/msg/PoseWithCovarianceStamped", STATE, rate)
        place, heading = (max(each.mount.noise**2, EXACT) for each in (position, orientation))
        self._covariance = messages.diagonal([place, place, place, UNMEASURED, UNMEASURED, heading])

    def publish(self) -> None:
        position, (yaw,) = self._position.read(), self._orientation.read().values
        x, y, z = position.values
        pose = Pose3(x, y, z, yaw=yaw)
        self._publisher.send(messages.pose_with_covariance(position.stamp, MAP, pose, self._covariance))


class _Values(Output):
    """Values of a sensor for which there is no standard message."""

    def __init__(self, sensor: Sensor, rate: Rate, names: RobotPublishers) -> None:
        super().__init__(sensor.name, rate)
        self._sensor = sensor
        self._publisher = names.publisher(sensor.name, "std_msgs/msg/Float64MultiArray", SENSORS, rate)

    def publish(self) -> None:
        self._publisher.send({"data": np.asarray(self._sensor.read().values, np.float64)})


def robot_outputs(
    devices: RobotDevices, locomotion: Locomotion, names: RobotPublishers, links: RobotLinks
) -> list[Output]:
    """Outputs for all sensors of a robot; constant transforms are added to `names`.

    Args:
        devices: Devices of the robot, in MuJoCo.
        locomotion: Locomotion of the robot.
        names: RobotPublishers of the robot on the network.
        links: Links of the robot.
    """
    names.fix(names.frame(FOOTPRINT), names.frame(BASE), Pose3(0.0, 0.0, links.height))
    found = [*_pose_outputs(devices, locomotion, names, links), *_sensor_outputs(devices, names, links)]
    if names.tf is not None and len(links.links) > 1:
        rate = min((each.rate for each in found), key=lambda rate: rate.period)
        found.append(_Joined(links, names.tf, rate, names))
    return found


def _pose_outputs(
    devices: RobotDevices, locomotion: Locomotion, names: RobotPublishers, links: RobotLinks
) -> Iterator[Output]:
    """Odometry: ground truth if position and orientation are ideal sensors, else from the encoders."""
    rates, world = devices.sensor_rates, None
    position, orientation = _all(devices, Position), _all(devices, Orientation)
    if position and orientation:
        rate = rates[position[0].name]
        if position[0].mount.noise == orientation[0].mount.noise == 0.0:
            world = position[0].mount.world
            if names.options.map_to_odom:
                names.fix(MAP, names.frame(ODOM), Pose3(0.0, 0.0, 0.0))
            yield _Odometry(partial(_truth, world, names.robot), rate, names, links.height)
        else:
            yield _PoseFix(position[0], orientation[0], rate, names)
    actuator = next(a for a in devices.robot.actuators if a.name == devices.robot.locomotion.actuator)
    motors = tuple(actuator.parameters.get("motors", ()))
    for sensor in _encoders(devices):
        if world is None and locomotion.wheeled and {*motors} == {*sensor.parameters.motors}:
            odometry = WheelOdometry(sensor, locomotion, motors, links.height)
            yield _Odometry(odometry, rates[sensor.name], names, links.height)
            break


def _truth(world: DriverWorld, robot: str) -> Motion:
    return Motion(world.stamp, world.pose3(robot), world.twist3(robot), _TRUE_POSE, _TRUE_TWIST)


def _sensor_outputs(devices: RobotDevices, names: RobotPublishers, links: RobotLinks) -> Iterator[Output]:
    """Outputs of all sensors except position and orientation; the only one of its kind has a standard topic."""
    covered: set[str] = set()  # motors with joint states
    for encoders in _encoders(devices):
        if covered.isdisjoint(encoders.parameters.motors):
            covered.update(encoders.parameters.motors)
            yield _Joints(encoders, devices.sensor_rates[encoders.name], names)
    standard: tuple[tuple[Any, str, Callable[..., Output]], ...] = ((Lidar, "scan", _Scan), (Gyro, "imu", _Imu))
    others = (Position, Orientation, WheelTravel, WheelSpeed, MailboxSensor)
    for sensor in devices.sensors.values():
        rate = devices.sensor_rates[sensor.name]
        for cls, topic, make in standard:
            if isinstance(sensor, cls):
                alone = len(_all(devices, cls)) == 1
                yield make(sensor, topic if alone else f"{topic}/{sensor.name}", rate, names, links)
                break
        else:
            if isinstance(sensor, RangeCone):
                yield _Ranges(sensor, rate, names, links)
            elif not isinstance(sensor, others):
                yield _Values(sensor, rate, names)


def _encoders(devices: RobotDevices) -> list[WheelSpeed | WheelTravel]:
    """Encoders of a robot, those of the wheels' travel first, because they lose nothing between readings."""
    return [*_all(devices, WheelTravel), *_all(devices, WheelSpeed)]


def _all(devices: RobotDevices, cls: type[T]) -> list[T]:
    return [sensor for sensor in devices.sensors.values() if isinstance(sensor, cls)]


def _beam(site: Pose3) -> Pose3:
    """Frame of a beam along the z axis of a site: x is along the beam, and y is horizontal."""
    ahead, left, up = _vertical(site)
    return Pose3(*site[:3], 0.0, -math.asin(min(1.0, max(-1.0, up))), math.atan2(left, ahead))


def _below(pose: Pose3, height: float) -> Pose3:
    """Pose of `base_footprint`, at a height [m] below a base with its orientation."""
    x, y, z = (at - height * each for at, each in zip(pose[:3], _vertical(pose), strict=True))
    return Pose3(x, y, z, *pose[3:])


def _vertical(pose: Pose3) -> tuple[float, float, float]:
    """Unit vector of the z axis of a pose."""
    w, i, j, k = pose.quaternion
    return 2.0 * (i * k + w * j), 2.0 * (j * k - w * i), 1.0 - 2.0 * (i * i + j * j)
