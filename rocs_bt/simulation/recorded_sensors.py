"""Topics of recorded sensors: standard ROS 2 messages from readings."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from .. import event as ev
from ..catalog import RobotSpec, SensorSpec
from ..drivers import DRIVER_PARAMETERS, read_parameters
from ..drivers.ros2 import messages
from ..geometry import Pose3
from ..record import BodyInfo

BASE = "base_link"
"""Frame of the body (REP 105)."""

_INVALID = re.compile(r"[^A-Za-z0-9]+")


class Published(NamedTuple):
    """Message of a topic.

    Attributes:
        topic: Full name of the topic.
        t: Time of publication [s].
        type: Message type.
        fields: Fields of the message, for `MessageTypes.make`.
        latched: Whether late subscriptions need it, so that its durability is transient local.
    """

    topic: str
    t: float
    type: str
    fields: Mapping[str, Any]
    latched: bool = False


Convert = Callable[[ev.SensorRead], Iterable[Published]]
"""Function from a reading to messages."""


class Names:
    """Names and times of the messages of one agent.

    Args:
        namespace: Name before topics and frames; empty for none.
        start: Time of the messages at time 0 of the run [s since 1970].
    """

    def __init__(self, namespace: str, start: float) -> None:
        self.start = start
        self._space = namespace
        self._full: dict[str, str] = {}

    def full(self, name: str) -> str:
        """Full name of a topic or frame, without a leading slash."""
        if name not in self._full:
            self._full[name] = "/".join(filter(None, (self._space, *map(ros_name, name.split("/")))))
        return self._full[name]

    def published(self, topic: str, t: float, kind: str, fields: Mapping[str, Any]) -> Published:
        """Message of a topic at a time of the run [s]."""
        return Published(f"/{self.full(topic)}", self.start + t, kind, fields)

    def numbers(self, topic: str, t: float, values: Sequence[float]) -> Published:
        """Message with one number or several."""
        if len(values) == 1:
            return self.published(topic, t, "std_msgs/msg/Float64", {"data": values[0]})
        return self.published(topic, t, "std_msgs/msg/Float64MultiArray", {"data": values})

    def text(self, topic: str, t: float, text: str) -> Published:
        """Message with a text."""
        return self.published(topic, t, "std_msgs/msg/String", {"data": text})


class SensorTopics:
    """Topics of the sensors of one agent.

    Args:
        body: Body of the agent, with the beams of its sensors.
        robot: Its robot; None if unknown.
        joints: Joints of the robot by motor.
        names: Names and times of its messages.

    Attributes:
        ranging: Signals with the ranges of these sensors.
    """

    def __init__(self, body: BodyInfo, robot: RobotSpec | None, joints: Mapping[str, str], names: Names) -> None:
        self._body = body
        self._sensors = {sensor.name: sensor for sensor in robot.sensors} if robot else {}
        self._joints = joints
        self._names = names
        self._converters: dict[str, Convert] = {}
        self.ranging = {s.signal for s in self._sensors.values() if s.name in {*body.beams, *body.fans}}

    def frames(self) -> Iterator[tuple[str, Pose3]]:
        """Frames of the sensors, and their poses on the body."""
        for sensor, fan in self._body.fans.items():
            middle = fan.yaw + fan.step * (fan.rays - 1) / 2.0
            yield self._names.full(sensor), Pose3(fan.x, fan.y, 0.0, yaw=middle)
        for sensor, beams in self._body.beams.items():
            for name, beam in zip(self._beam_names(sensor), beams, strict=True):
                yield self._names.full(name), Pose3(beam.x, beam.y, 0.0, yaw=beam.yaw)

    def take(self, event: ev.SensorRead) -> Iterable[Published]:
        """Messages with a reading."""
        if event.sensor not in self._converters:
            self._converters[event.sensor] = self._converter(event.sensor)
        return self._converters[event.sensor](event)

    def _converter(self, sensor: str) -> Convert:
        """Function that makes the messages of a sensor."""
        spec = self._sensors.get(sensor)
        driver = spec.driver if spec else ""
        if sensor in self._body.fans:
            return self._scans(sensor, spec)
        if sensor in self._body.beams:
            return self._ranges(sensor)
        if driver == "gyro":
            topic, frame, kind = self._alone("imu", spec), self._names.full(BASE), "sensor_msgs/msg/Imu"
            return lambda e: [
                self._names.published(topic, e.t, kind, messages.imu(self._names.start + e.stamp, frame, e.values[0]))
            ]
        if spec and driver in ("wheel_speed", "wheel_travel"):
            return self._wheels(spec)
        if driver == "mailbox":
            return lambda e: ()
        return lambda e: [self._names.numbers(f"sensors/{sensor}", e.t, e.values)]

    def _alone(self, topic: str, spec: SensorSpec | None, *others: str) -> str:
        """Topic of a sensor: the standard one if it is the only sensor of its kind."""
        kinds = {spec.driver, *others} if spec else set(others)
        alike = [s for s in self._sensors.values() if s.driver in kinds]
        return topic if spec is None or len(alike) < 2 else f"{topic}/{spec.name}"

    def _limits(self, sensor: str, reach: float) -> tuple[float, float]:
        """Minimum and maximum range of a sensor [m]."""
        spec = self._sensors.get(sensor)
        return (spec.parameters.get("range", (0.0,))[0] if spec else 0.0), reach

    def _beam_names(self, sensor: str) -> Sequence[str]:
        """Names of the beams of a sensor: its sites if known."""
        count, spec = len(self._body.beams[sensor]), self._sensors.get(sensor)
        sites = spec.parameters.get("sites", ()) if spec else ()
        return sites if len(sites) == count else [f"{sensor}{i}" for i in range(count)]

    def _scans(self, sensor: str, spec: SensorSpec | None) -> Convert:
        fan, frame = self._body.fans[sensor], self._names.full(sensor)
        topic = "scan" if len(self._body.fans) == 1 else f"scan/{sensor}"
        first, limits = -fan.step * (fan.rays - 1) / 2.0, self._limits(sensor, fan.reach)
        period = 1.0 / spec.rate if spec and spec.rate else 0.0

        def convert(e: ev.SensorRead) -> Iterator[Published]:
            ranges = e.values
            if len(ranges) == fan.rays:
                at, step = self._names.start + e.stamp, fan.step
                fields = messages.laser_scan(at, frame, ranges, first=first, step=step, limits=limits, period=period)
                yield self._names.published(topic, e.t, "sensor_msgs/msg/LaserScan", fields)

        return convert

    def _ranges(self, sensor: str) -> Convert:
        beams, names = self._body.beams[sensor], self._beam_names(sensor)
        known = [(beam, name, self._limits(sensor, beam.reach)) for beam, name in zip(beams, names, strict=True)]

        def convert(e: ev.SensorRead) -> Iterator[Published]:
            at = self._names.start + e.stamp
            for (beam, name, limits), value in zip(known, e.values, strict=False):
                fields = messages.sonar_range(at, self._names.full(name), value, opening=beam.cone, limits=limits)
                yield self._names.published(f"range/{name}", e.t, "sensor_msgs/msg/Range", fields)

        return convert

    def _wheels(self, spec: SensorSpec) -> Convert:
        given: Any = read_parameters(DRIVER_PARAMETERS[spec.driver], spec.parameters, f"sensor '{spec.name}'")
        topic = self._alone("joint_states", spec, "wheel_speed", "wheel_travel")
        joints = [self._joints.get(motor, motor) for motor in given.motors]

        def convert(e: ev.SensorRead) -> Iterator[Published]:
            values = e.values
            if len(values) == given.size:
                angles = [value / factor for value, factor in zip(values, given.factors, strict=True)]
                state = ((), angles) if spec.driver == "wheel_speed" else (angles, ())
                fields = messages.joint_state(self._names.start + e.stamp, joints, *state)
                yield self._names.published(topic, e.t, "sensor_msgs/msg/JointState", fields)

        return convert


def ros_names(names: Iterable[str]) -> dict[str, str]:
    """Names that ROS accepts, different for different names."""
    found: dict[str, str] = {}
    for name in names:
        if name in found:
            continue
        wanted, count = ros_name(name), 1
        while wanted in found.values():
            count += 1
            wanted = f"{ros_name(name)}_{count}"
        found[name] = wanted
    return found


def ros_name(name: str) -> str:
    """The nearest name that ROS accepts: letters, digits and single underscores, no digit first."""
    plain = _INVALID.sub("_", name).strip("_") or "unnamed"
    return f"n{plain}" if plain[0].isdigit() else plain
