"""Topics of a simulated robot: its sensors' readings as standard ROS 2 messages."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import numpy as np

from ...agent import RobotDevices
from ...base.clock import Rate
from ...base.geometry import Pose3
from ...control.locomotion import Locomotion
from ...devices.simulated import (
    Gyro,
    Lidar,
    MailboxSensor,
    Orientation,
    Position,
    RangeCone,
    Scene,
    Velocity,
    WheelSpeed,
    WheelTravel,
)
from ...interfaces.device import Sensor
from ...simulation.robot_links import RobotLinks
from ..messages import fields as messages
from ..messages.fields import UNMEASURED
from ..messages.message_types import IMU, JOINTS, ODOMETRY, POSE_FIX, RANGE, SCAN, Channel, Values, pose_values
from ..messages.names import BASE, FOOTPRINT, MAP, ODOM
from ..network.qos import QoS
from .publishers import RobotPublishers, TfPublishers
from .wheel_odometry import EXACT, Motion, WheelOdometry

T = TypeVar("T")

STATE = QoS("reliable", "volatile", 10)
"""Quality of service of odometry, joint states and transforms, as robots offer it."""

SENSORS = QoS("reliable", "volatile", 5)
"""Quality of service of scans and other readings, which reliable and best-effort subscriptions can receive."""

_TRUE_POSE = messages.diagonal([EXACT] * 6)
_TRUE_TWIST = messages.diagonal([EXACT, EXACT, EXACT, UNMEASURED, UNMEASURED, EXACT])


@dataclass
class Output:
    """Publisher of the readings of one or more sensors.

    Attributes:
        name: Name of the sensor, or of the topic.
        rate: Rate in control periods.
        publish: Reads the sensors and publishes; raises DeviceError if a sensor has no sample.
    """

    name: str
    rate: Rate
    publish: Callable[[], None]


def _output(
    sensor: Sensor,
    rate: Rate,
    names: RobotPublishers,
    kind: str,
    topics: Mapping[str, Channel],
    values: Callable[[Sequence[float]], Iterable[Values]],
    *,
    qos: QoS = SENSORS,
) -> Output:
    """Publisher of the readings of a sensor, on topics of a type: for each the channel, and the part of the values."""
    publishers = [(names.publisher(topic, kind, qos, rate), channel) for topic, channel in topics.items()]

    def publish() -> None:
        reading = sensor.read()
        for (publisher, channel), each in zip(publishers, values(reading.values), strict=True):
            publisher.measure(reading.stamp, each, channel)

    return Output(sensor.name, rate, publish)


def _scan(sensor: Lidar, topic: str, rate: Rate, names: RobotPublishers, links: RobotLinks) -> Output:
    """Scan of a lidar."""
    frame, given = names.frame(sensor.name), sensor
    link, pose = links.site(given.site)
    names.fix(names.frame(link), frame, pose)
    first, step, times = -0.5 * given.span, given.span / (given.rays - 1), (rate.period, given.sweep)
    channel = Channel(frame, first=first, step=step, limits=given.range, times=times)
    return _output(sensor, rate, names, SCAN, {topic: channel}, lambda values: [{"ranges": values}])


def _ranges(sensor: RangeCone, topic: str, rate: Rate, names: RobotPublishers, links: RobotLinks) -> Output:
    """Ranges of sensors with conical beams, one topic for each beam."""
    beams = {}
    for site in sensor.sites:
        link, pose = links.site(site)
        names.fix(names.frame(link), names.frame(site), _beam(pose))
        beams[f"range/{site}"] = Channel(names.frame(site), opening=2.0 * sensor.half_angle, limits=sensor.range)
    return _output(sensor, rate, names, RANGE, beams, lambda values: [{"range": [value]} for value in values])


def _imu(sensor: Gyro, topic: str, rate: Rate, names: RobotPublishers, links: RobotLinks) -> Output:
    """Turn rate of a gyro."""
    frame = names.frame(sensor.name)
    variance = max(sensor.noise**2 + sensor.bias_noise**2, EXACT)
    covariance = messages.diagonal([UNMEASURED, UNMEASURED, variance])
    names.fix(names.frame(BASE), frame, Pose3(0.0, 0.0, 0.0))
    channel = Channel(frame, covariances={"angular_velocity": covariance})
    return _output(sensor, rate, names, IMU, {topic: channel}, lambda values: [{"turn_rate": values}])


def _joints(sensor: WheelSpeed | WheelTravel, rate: Rate, names: RobotPublishers, links: RobotLinks) -> Output:
    """Angles and speeds of the motors that encoders measure."""
    world, joints = sensor.world, links.joints(sensor.handle)

    def values(values: Sequence[float]) -> Iterator[Values]:
        measured = [v / f for v, f in zip(values, sensor.factors, strict=True)]
        if isinstance(sensor, WheelTravel):
            yield {"position": measured, "velocity": world.motor_speeds(sensor.handle)}
        else:
            yield {"position": world.motor_angles(sensor.handle), "velocity": measured}

    return _output(sensor, rate, names, JOINTS, {"joint_states": Channel(names=joints)}, values, qos=STATE)


def _odometry(read: Callable[[], Motion], rate: Rate, names: RobotPublishers, height: float) -> Output:
    """Odometry of `base_link`, and the transform from `odom` to `base_footprint`, which is below it."""
    publisher = names.publisher("odom", ODOMETRY, STATE, rate)
    tf = names.tf if names.options.odom_to_base else None
    odom, footprint, base = map(names.frame, (ODOM, FOOTPRINT, BASE))

    def publish() -> None:
        stamp, pose, twist, *errors = read()
        channel = Channel(odom, base, covariances=dict(zip(("pose", "twist"), errors, strict=True)))
        publisher.measure(stamp, {**pose_values(pose), "twist": twist}, channel)
        if tf is not None:
            tf.send([messages.transform(stamp, odom, footprint, _below(pose, height))])

    return Output("odom", rate, publish)


def _joined(links: RobotLinks, tf: TfPublishers, rate: Rate, names: RobotPublishers) -> Output:
    """Transforms of the links on joints."""

    def publish() -> None:
        stamp, found = links.poses()
        frame = names.frame
        tf.send([messages.transform(stamp, frame(parent), frame(link), pose) for parent, link, pose in found])

    return Output("links", rate, publish)


def _pose_fix(position: Position, orientation: Orientation, rate: Rate, names: RobotPublishers) -> Output:
    """Noisy measurements of the pose in the map."""
    place, heading = (max(each.noise**2, EXACT) for each in (position, orientation))
    covariance = messages.diagonal([place, place, place, UNMEASURED, UNMEASURED, heading])

    def values(place: Sequence[float]) -> Iterator[Values]:
        yield {"position": place, "orientation": orientation.read().values}

    channel = Channel(MAP, covariances={"pose": covariance})
    return _output(position, rate, names, POSE_FIX, {"pose": channel}, values, qos=STATE)


def _values(sensor: Sensor, topic: str, rate: Rate, names: RobotPublishers, links: RobotLinks) -> Output:
    """Values of a sensor for which there is no standard message."""
    publisher = names.publisher(sensor.name, "std_msgs/msg/Float64MultiArray", SENSORS, rate)
    return Output(sensor.name, rate, lambda: publisher.send({"data": np.asarray(sensor.read().values, np.float64)}))


def robot_outputs(
    devices: RobotDevices, locomotion: Locomotion, names: RobotPublishers, links: RobotLinks
) -> list[Output]:
    """Outputs for all sensors of a robot; constant transforms are added to `names`."""
    names.fix(names.frame(FOOTPRINT), names.frame(BASE), Pose3(0.0, 0.0, links.height))
    found = [*_pose_outputs(devices, locomotion, names, links), *_sensor_outputs(devices, names, links)]
    if names.tf is not None and len(links.links) > 1:
        rate = min((each.rate for each in found), key=lambda rate: rate.period)
        found.append(_joined(links, names.tf, rate, names))
    return found


def _pose_outputs(
    devices: RobotDevices, locomotion: Locomotion, names: RobotPublishers, links: RobotLinks
) -> Iterator[Output]:
    """Odometry: ground truth if position and orientation are ideal sensors, else from the encoders."""
    rates, world = devices.sensor_rates, None
    position, orientation = _all(devices, Position), _all(devices, Orientation)
    if position and orientation:
        rate = rates[position[0].name]
        if position[0].exact and orientation[0].exact:
            world = position[0].world
            if names.options.map_to_odom:
                names.fix(MAP, names.frame(ODOM), Pose3(0.0, 0.0, 0.0))
            yield _odometry(partial(_truth, world, names.robot), rate, names, links.height)
        else:
            yield _pose_fix(position[0], orientation[0], rate, names)
    given = devices.robot.mover.parameters
    motors = given.motors if isinstance(given, Velocity) else ()
    for sensor in _encoders(devices):
        if world is None and locomotion.wheeled and {*motors} == {*sensor.motors}:
            odometry = WheelOdometry(sensor, locomotion, motors, links.height)
            yield _odometry(odometry, rates[sensor.name], names, links.height)
            break


def _truth(world: Scene, robot: str) -> Motion:
    return Motion(world.stamp, world.pose3(robot), world.twist3(robot), _TRUE_POSE, _TRUE_TWIST)


def _sensor_outputs(devices: RobotDevices, names: RobotPublishers, links: RobotLinks) -> Iterator[Output]:
    """Outputs of all sensors except position and orientation; the only one of its kind has a standard topic."""
    covered: set[str] = set()  # motors with joint states
    for encoders in _encoders(devices):
        if covered.isdisjoint(encoders.motors):
            covered.update(encoders.motors)
            yield _joints(encoders, devices.sensor_rates[encoders.name], names, links)
    for sensor in devices.sensors.values():
        cls, topic, make = next(row for row in _OUTPUTS if isinstance(sensor, row[0]))
        if make is not None:
            alone = len(_all(devices, cls)) == 1
            rate = devices.sensor_rates[sensor.name]
            yield make(sensor, topic if alone else f"{topic}/{sensor.name}", rate, names, links)


_OUTPUTS: tuple[tuple[Any, str, Callable[..., Output] | None], ...] = (
    (Lidar, "scan", _scan),
    (RangeCone, "range", _ranges),
    (Gyro, "imu", _imu),
    *((cls, "", None) for cls in (Position, Orientation, WheelTravel, WheelSpeed, MailboxSensor)),
    (Sensor, "", _values),
)
"""Outputs by class of sensor: topic of the only sensor of the class, and its maker; None if another output has it."""


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
