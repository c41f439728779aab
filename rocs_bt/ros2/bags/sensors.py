"""Topics of recorded sensors: standard ROS 2 messages from readings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ... import event as ev
from ...base.geometry import Pose3
from ...catalog import RobotSpec, SensorSpec
from ...record import BodyInfo
from ..devices.parameters import Ros2SensorParameters
from ..messages.message_types import IMU, JOINTS, MESSAGES, RANGE, SCAN, Channel, Values
from ..messages.names import BASE, MAP
from .messages import BagMessages, Published

_SAME = 0.002
"""Maximum difference of the stamps that two sensors give one message [s]: each reads the clock by itself."""

_WHEELS = {"wheel_speed": "velocity", "wheel_travel": "position"}


@dataclass
class _Part:
    """Values of one sensor in the messages of a topic."""

    taken: str
    channel: Channel
    factors: Sequence[float]  # from the numbers of a message to the values of a reading
    repeats: bool = False  # whether readings are repeated, or NaN, while there is no message
    stamp: float = -math.inf  # of the newest reading [s]
    values: Sequence[float] = ()  # newest values, in the unit of the message


@dataclass
class _Topic:
    """Topic from which one or more sensors take values."""

    name: str
    type: str
    parts: dict[str, _Part] = field(default_factory=dict)  # by sensor
    waiting: set[str] = field(default_factory=set)  # sensors with values that no message has yet
    since: float = 0.0  # time since which they wait [s]
    stamp: float = 0.0  # of the next message [s]


class SensorTopics:
    """Topics of the sensors of one agent.

    Values that several sensors with `driver = "ros2"` take from one message are in one message again. A reading that
    one repeats, because its topic was silent, makes no message. Each transform has messages of its own. Of several
    sensors that take a scan from one topic, the one with the widest span makes its messages. Values of sensors that
    list fields (`values`), and of those without a standard message, are numbers.

    Args:
        body: Body of the agent, with the beams of its sensors.
        robot: Its robot; None if unknown.
        joints: Joints of the robot by motor.
        names: Names and times of its messages.
        period: Maximum time for which a message waits for the values of all its sensors [s].
    """

    def __init__(
        self, body: BodyInfo, robot: RobotSpec | None, joints: Mapping[str, str], names: BagMessages, period: float
    ) -> None:
        self._body = body
        self._sensors = {sensor.name: sensor for sensor in robot.sensors} if robot else {}
        self._joints = joints
        self._names = names
        self._period = period
        self._topics: dict[tuple[str, ...], _Topic] = {}
        self._of: dict[str, list[tuple[_Topic, _Part]]] = {}  # by sensor
        for sensor in dict.fromkeys([*self._sensors, *body.fans, *body.beams]):
            self._open(sensor, self._sensors.get(sensor))
        for topic in self._topics.values():
            if "span" in MESSAGES[topic.type].keys:
                topic.parts = dict([max(topic.parts.items(), key=_width)])
        ranging = {name for name, pairs in self._of.items() if any("zero" in MESSAGES[t.type].keys for t, _ in pairs)}
        self.ranging = {spec.signal for spec in self._sensors.values() if spec.name in ranging}

    @property
    def topics(self) -> set[str]:
        """Full names of the topics."""
        return {self._names.topic(topic.name) for topic in self._topics.values()}

    def frames(self) -> Iterator[tuple[str, Pose3]]:
        """Frames of the sensors, and their poses on the body."""
        for sensor, fan in self._body.fans.items():
            middle = fan.yaw + fan.step * (fan.rays - 1) / 2.0
            yield self._names.frame(sensor), Pose3(fan.x, fan.y, 0.0, yaw=middle)
        for sensor, beams in self._body.beams.items():
            for name, beam in zip(self._beam_names(sensor), beams, strict=True):
                yield self._names.frame(name), Pose3(beam.x, beam.y, 0.0, pitch=-beam.elevation, yaw=beam.yaw)
        for topic in self._topics.values():
            for sensor, part in topic.parts.items():
                spec = self._sensors.get(sensor)
                if part.repeats and "span" in MESSAGES[topic.type].keys and spec and (mount := spec.mount) is not None:
                    yield self._names.frame(sensor), Pose3(mount.x, mount.y, 0.0, yaw=mount.yaw)

    def take(self, event: ev.SensorRead) -> Iterator[Published]:
        """Messages that are complete with a reading."""
        values, pairs = event.values, self._of.get(event.sensor)
        if pairs is None:
            yield self._names.numbers(f"sensors/{event.sensor}", event.t, values)
        elif len(values) == sum(len(part.factors) for _, part in pairs):
            left = iter(values)
            for topic, part in pairs:
                yield from self._read(topic, part, event, [value for _, value in zip(part.factors, left, strict=False)])

    def finished(self, t: float, *, over: bool = False) -> Iterator[Published]:
        """Messages that have waited long enough, with the newest values of sensors that have no new ones.

        Args:
            t: Present time [s].
            over: Whether the recording ends.
        """
        for topic in self._topics.values():
            if topic.waiting and (over or t - topic.since >= self._period):
                yield self._message(topic, t)

    def _read(self, topic: _Topic, part: _Part, event: ev.SensorRead, values: Sequence[float]) -> Iterator[Published]:
        """Messages of a topic that are complete with these values of a reading."""
        silent = part.repeats and (event.stamp == part.stamp or all(map(math.isnan, values)))
        if silent or event.sensor not in topic.parts:
            return
        if topic.waiting and (event.sensor in topic.waiting or abs(event.stamp - topic.stamp) > _SAME):
            yield self._message(topic, event.t)
        if not topic.waiting:
            topic.since, topic.stamp = event.t, event.stamp
        part.stamp = event.stamp
        part.values = [value / factor for value, factor in zip(values, part.factors, strict=True)]
        topic.waiting.add(event.sensor)
        if len(topic.waiting) == len(topic.parts):
            yield self._message(topic, event.t)

    def _message(self, topic: _Topic, t: float) -> Published:
        topic.waiting.clear()
        values, channel = _together([part for part in topic.parts.values() if part.values])
        return self._names.measured(topic.name, t, topic.stamp, topic.type, values, channel)

    def _open(self, sensor: str, spec: SensorSpec | None) -> None:
        """Add the topics of a sensor; none for one without a standard message."""
        body, names, driver = self._body, self._names, spec.driver if spec else ""
        if spec and isinstance(given := spec.parameters, Ros2SensorParameters) and given.taken:
            channel, factors = self._channel(spec, given), [given.scale(spec.scale)] * (given.size or 0)
            ends = (given.frame, given.child) if "frame" in given.keys else ()
            for topic in given.all_topics:
                part = _Part(given.taken, channel, factors[:: len(given.all_topics)], repeats=True)
                self._add(sensor, topic, given.type, part, *ends)
        elif fan := body.fans.get(sensor):
            first, limits = -fan.step * (fan.rays - 1) / 2.0, (fan.nearest, fan.reach)
            times = (1.0 / (spec.rate or math.inf) if spec else 0.0, fan.sweep)
            channel = Channel(names.frame(sensor), first=first, step=fan.step, limits=limits, times=times)
            topic = "scan" if len(body.fans) == 1 else f"scan/{sensor}"
            self._add(sensor, topic, SCAN, _Part("ranges", channel, [1.0] * fan.rays), sensor)
        elif sensor in body.beams:
            for name, beam in zip(self._beam_names(sensor), body.beams[sensor], strict=True):
                channel = Channel(names.frame(name), opening=beam.cone, limits=(beam.nearest, beam.reach))
                self._add(sensor, f"range/{name}", RANGE, _Part("range", channel, [1.0]), sensor)
        elif spec and driver == "gyro":
            part = _Part("turn_rate", Channel(names.frame(BASE)), [1.0])
            self._add(sensor, self._alone("imu", spec, "gyro"), IMU, part, sensor)
        elif spec and driver in _WHEELS:
            wheels: Any = spec.parameters
            channel = Channel(names=[self._joints.get(motor, motor) for motor in wheels.motors])
            part = _Part(_WHEELS[driver], channel, wheels.factors)
            self._add(sensor, self._alone("joint_states", spec, *_WHEELS), JOINTS, part, sensor)
        elif driver == "mailbox":
            self._of[sensor] = []

    def _add(self, sensor: str, name: str, kind: str, part: _Part, *ends: str) -> None:
        topic = self._topics.setdefault((name, kind, *ends), _Topic(name, kind))
        topic.parts[sensor] = part
        self._of.setdefault(sensor, []).append((topic, part))

    def _channel(self, spec: SensorSpec, given: Ros2SensorParameters) -> Channel:
        """Channel of a sensor's values. The limits of a scanner are not recorded, but the readings keep to them."""
        form, names = MESSAGES[given.type], self._names
        frame = form.frame if form.frame in ("", MAP) else names.frame(form.frame)
        if "span" in form.keys and spec.mount is not None:
            frame = names.frame(spec.name)
        return Channel(
            frame=given.frame if "frame" in form.keys else frame,
            child=given.child if "child" in form.keys else names.frame(BASE),
            first=-0.5 * given.span,
            step=given.span / max(given.rays - 1, 1),
            names=(given.joints or (given.status or spec.name,)) if form.parts else (),
            words=given.words,
        )

    def _alone(self, topic: str, spec: SensorSpec, *kinds: str) -> str:
        """Topic of a sensor: the standard one if it is the only sensor of its kind."""
        alike = [s for s in self._sensors.values() if s.driver in kinds]
        return topic if len(alike) < 2 else f"{topic}/{spec.name}"

    def _beam_names(self, sensor: str) -> Sequence[str]:
        return [beam.name or f"{sensor}{i}" for i, beam in enumerate(self._body.beams[sensor])]


def _width(named: tuple[str, _Part]) -> tuple[float, int]:
    """Direction of the last ray of a sensor's scan [rad], and its number of rays."""
    return -named[1].channel.first, len(named[1].factors)


def _together(parts: Sequence[_Part]) -> tuple[Values, Channel]:
    """Values of sensors by what they take, the newest of each, and their channel; values with names by all names."""
    names = list(dict.fromkeys(name for part in parts for name in part.channel.names))
    values: dict[str, Sequence[float]] = {}
    for part in (ordered := sorted(parts, key=lambda part: part.stamp)):
        own = dict(zip(part.channel.names, part.values, strict=False))
        before = values.get(part.taken, [math.nan] * len(names))
        values[part.taken] = [own.get(n, v) for n, v in zip(names, before, strict=True)] if names else part.values
    return values, replace(ordered[-1].channel, names=names)
