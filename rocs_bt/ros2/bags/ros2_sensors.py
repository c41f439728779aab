"""Topics of recorded sensors with `driver = "ros2"`: readings as messages of the types from which they were taken."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ... import event as ev
from ...base.geometry import Pose3, Twist3
from ...catalog import RobotSpec, SensorSpec
from ...drivers import ROS2, read_parameters
from ..devices.parameters import DIAGNOSTICS, JOINTS, NUMBER, SCAN, STRING, TRANSFORMS, Ros2SensorParameters
from ..messages import fields as messages
from ..messages.names import BASE, MAP, ODOM
from .messages import BagMessages, Published

_SAME = 0.002
"""Maximum difference of the stamps that two sensors give one message [s]: each reads the clock by itself."""

_UNKNOWN = [-1.0, *[0.0] * 8]  # covariance of what an Imu does not measure


@dataclass
class _Part:
    """One sensor of a topic.

    Attributes:
        spec: Table of the sensor.
        given: Keys of the sensor for the driver.
        stamp: Stamp of its newest reading [s].
        values: Newest values, in the unit of the message.
    """

    spec: SensorSpec
    given: Ros2SensorParameters
    stamp: float = -math.inf
    values: Sequence[float] = ()


@dataclass
class _Topic:
    """Topic from which one or more sensors take values.

    Attributes:
        name: Name of the topic, as in robot.toml.
        type: Message type.
        parts: Sensors by name.
        waiting: Sensors with values that no message has yet.
        since: Time since which they wait [s].
        stamp: Stamp of the next message [s].
    """

    name: str
    type: str
    parts: dict[str, _Part] = field(default_factory=dict)
    waiting: set[str] = field(default_factory=set)
    since: float = 0.0
    stamp: float = 0.0


class Ros2Topics:
    """Topics of the sensors with `driver = "ros2"` of one agent.

    Values that several sensors take from one message are in one message again. A reading that a sensor repeats, because
    its topic was silent, makes no message. Each transform has messages of its own. Of several sensors that take a scan
    from one topic, the one with the widest span makes its messages. Sensors that list fields (`values`) are left out.

    Args:
        robot: Robot of the agent; None if unknown.
        names: Names and times of its messages.
        period: Maximum time for which a message waits for the values of all its sensors [s].
    """

    def __init__(self, robot: RobotSpec | None, names: BagMessages, period: float) -> None:
        self._names = names
        self._period = period
        self._topics: dict[tuple[str, ...], _Topic] = {}
        self._of: dict[str, list[tuple[_Topic, _Part]]] = {}
        for spec in robot.sensors if robot else ():
            if spec.driver != ROS2:
                continue
            given = read_parameters(Ros2SensorParameters, spec.parameters, f"sensor '{spec.name}'")
            if given.taken:
                ends = (given.frame, given.child) if given.type == TRANSFORMS else ()
                for name in given.all_topics:
                    topic = self._topics.setdefault((name, given.type, *ends), _Topic(name, given.type))
                    part = topic.parts[spec.name] = _Part(spec, given)
                    self._of.setdefault(spec.name, []).append((topic, part))
        for topic in self._topics.values():
            if topic.type == SCAN:
                topic.parts = dict([max(topic.parts.items(), key=_width)])

    def __contains__(self, sensor: str) -> bool:
        return sensor in self._of

    @property
    def names(self) -> set[str]:
        """Full names of the topics."""
        return {name if name.startswith("/") else self._names.topic(name) for name, *_ in self._topics}

    @property
    def ranging(self) -> set[str]:
        """Names of the sensors that measure ranges."""
        kinds = (SCAN, "sensor_msgs/msg/Range")
        return {sensor for sensor, pairs in self._of.items() if pairs[0][0].type in kinds}

    def frames(self) -> Iterator[tuple[str, Pose3]]:
        """Frames of the laser scanners with a declared mount, and their poses on the body."""
        for topic in self._topics.values():
            for part in topic.parts.values():
                if topic.type == SCAN and (mount := part.spec.mount) is not None:
                    yield self._names.frame(part.spec.name), Pose3(mount.x, mount.y, 0.0, yaw=mount.yaw)

    def take(self, event: ev.SensorRead) -> Iterator[Published]:
        """Messages that are complete with a reading."""
        values, pairs = event.values, self._of[event.sensor]
        if len(values) != pairs[0][1].given.size:
            return
        each = len(values) // len(pairs)
        for i, (topic, part) in enumerate(pairs):
            read = values[i * each : (i + 1) * each]
            if event.sensor not in topic.parts or event.stamp == part.stamp or all(map(math.isnan, read)):
                continue
            if topic.waiting and (event.sensor in topic.waiting or abs(event.stamp - topic.stamp) > _SAME):
                yield self._message(topic, event.t)
            if not topic.waiting:
                topic.since, topic.stamp = event.t, event.stamp
            part.stamp = event.stamp
            scale = part.given.scale(part.spec.scale)
            part.values = [value / scale for value in read]
            topic.waiting.add(event.sensor)
            if len(topic.waiting) == len(topic.parts):
                yield self._message(topic, event.t)

    def finished(self, t: float, *, over: bool = False) -> Iterator[Published]:
        """Messages that have waited long enough, with the newest values of sensors that have no new ones.

        Args:
            t: Present time [s].
            over: Whether the recording ends.
        """
        for topic in self._topics.values():
            if topic.waiting and (over or t - topic.since >= self._period):
                yield self._message(topic, t)

    def _message(self, topic: _Topic, t: float) -> Published:
        topic.waiting.clear()
        read = [part for part in topic.parts.values() if part.values]
        fields = _FIELDS[topic.type](read, self._names, self._names.start + topic.stamp)
        return self._names.published(topic.name, t, topic.type, fields)


Fields = messages.Fields
_Make = Callable[[Sequence[_Part], BagMessages, float], Fields]
"""Function from the sensors of a message, names and stamp [s] to the fields of the message."""


def _width(named: tuple[str, _Part]) -> tuple[float, int]:
    """Span of a sensor's scan [rad], and its number of rays."""
    return named[1].given.span, named[1].given.rays


def _newest(parts: Sequence[_Part]) -> _Part:
    """Sensor with the newest reading."""
    return max(parts, key=lambda part: part.stamp)


def _taken(parts: Sequence[_Part]) -> dict[str, Sequence[float]]:
    """Values of the sensors by what they take."""
    return {part.given.taken: part.values for part in parts}


def _pose(taken: Mapping[str, Sequence[float]]) -> Pose3:
    x, y, z = taken.get("position", (0.0, 0.0, 0.0))
    (z,), (yaw,) = taken.get("height", (z,)), taken.get("orientation", (0.0,))
    roll, pitch = taken.get("attitude", (0.0, 0.0))
    return Pose3(x, y, z, roll, pitch, yaw)


def _scan(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    (part,) = parts
    spec, given = part.spec, part.given
    frame = names.frame(BASE if spec.mount is None else spec.name)
    step = given.span / (given.rays - 1)
    # The limits of the scanner are not recorded, but the readings keep to them.
    return messages.laser_scan(stamp, frame, part.values, first=-0.5 * given.span, step=step, limits=(0.0, math.inf))


def _range(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    (distance,) = _newest(parts).values
    return messages.sonar_range(stamp, names.frame(BASE), distance, opening=0.0, limits=(0.0, math.inf))


def _imu(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    taken = _taken(parts)
    (turn_rate,) = taken.get("turn_rate", (0.0,))
    fields = messages.imu(stamp, names.frame(BASE), turn_rate)
    if "turn_rate" not in taken:
        fields["angular_velocity_covariance"] = _UNKNOWN
    if {"orientation", "attitude"} & taken.keys():
        fields |= {"orientation": messages.quaternion(_pose(taken)), "orientation_covariance": [0.0] * 9}
    if "acceleration" in taken:
        fields["linear_acceleration"] = messages.vector(*taken["acceleration"])
        fields["linear_acceleration_covariance"] = [0.0] * 9
    return fields


def _odometry(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    taken = _taken(parts)
    twist = Twist3(*taken.get("twist", (0.0, 0.0, 0.0, 0.0)))
    return messages.odometry(stamp, names.frame(ODOM), names.frame(BASE), _pose(taken), twist)


def _joints(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    joints = list(dict.fromkeys(joint for part in parts for joint in part.given.joints))
    found: dict[str, list[float]] = {}
    for part in parts:
        values = found.setdefault(part.given.taken, [math.nan] * len(joints))
        for joint, value in zip(part.given.joints, part.values, strict=True):
            values[joints.index(joint)] = value / part.given.wheel_radius
    fields = messages.joint_state(stamp, joints, found.get("position", ()), found.get("velocity", ()))
    return {**fields, "effort": found.get("effort", ())}


def _pose_with_covariance(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    taken = _taken(parts)
    (spread,) = taken.get("spread", (0.0,))
    return messages.pose_with_covariance(stamp, MAP, _pose(taken), messages.diagonal([*[spread**2] * 3, 0.0, 0.0, 0.0]))


def _pose_stamped(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    return messages.pose_stamped(stamp, MAP, _pose(_taken(parts)))


def _battery(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    quantities = ("voltage", "temperature", "current", "charge", "capacity", "design_capacity", "percentage")
    measured = dict.fromkeys(quantities, math.nan)  # unmeasured, by the message's definition
    measured |= {name: value for name, (value,) in _taken(parts).items()}
    return {"header": messages.header(stamp, ""), **measured, "present": True}


def _diagnostics(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    status = [{"name": part.given.status or part.spec.name, "level": int(part.values[0])} for part in parts]
    return {"header": messages.header(stamp, ""), "status": status}


def _word(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    newest = _newest(parts)
    return {"data": newest.given.words[int(newest.values[0])]}


def _transforms(parts: Sequence[_Part], names: BagMessages, stamp: float) -> Fields:
    given = parts[0].given  # the frames are those of all parts
    return messages.transforms([messages.transform(stamp, given.frame, given.child, _pose(_taken(parts)))])


_FIELDS: Mapping[str, _Make] = {
    SCAN: _scan,
    "sensor_msgs/msg/Range": _range,
    "sensor_msgs/msg/Imu": _imu,
    "nav_msgs/msg/Odometry": _odometry,
    JOINTS: _joints,
    "geometry_msgs/msg/PoseWithCovarianceStamped": _pose_with_covariance,
    "geometry_msgs/msg/PoseStamped": _pose_stamped,
    "sensor_msgs/msg/BatteryState": _battery,
    DIAGNOSTICS: _diagnostics,
    "std_msgs/msg/Bool": lambda parts, names, stamp: {"data": bool(_newest(parts).values[0])},
    NUMBER: lambda parts, names, stamp: {"data": _newest(parts).values[0]},
    STRING: _word,
    TRANSFORMS: _transforms,
}
"""Fields of the message of each type with a short form."""
