"""Topics of recorded sensors: standard ROS 2 messages from readings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from ... import event as ev
from ...base.geometry import Pose3
from ...catalog import RobotSpec, SensorSpec
from ...drivers import DRIVER_PARAMETERS, read_parameters
from ...record import BodyInfo
from ..messages import fields as messages
from ..messages.names import BASE
from .messages import BagMessages, Published
from .ros2_sensors import Ros2Topics

Convert = Callable[[ev.SensorRead], Iterable[Published]]
"""Function from a reading to messages."""


class SensorTopics:
    """Topics of the sensors of one agent.

    Args:
        body: Body of the agent, with the beams of its sensors.
        robot: Its robot; None if unknown.
        joints: Joints of the robot by motor.
        names: Names and times of its messages.
        period: Control period [s].
    """

    def __init__(
        self, body: BodyInfo, robot: RobotSpec | None, joints: Mapping[str, str], names: BagMessages, period: float
    ) -> None:
        self._body = body
        self._sensors = {sensor.name: sensor for sensor in robot.sensors} if robot else {}
        self._joints = joints
        self._names = names
        self._converters: dict[str, Convert] = {}
        self.ros2 = Ros2Topics(robot, names, period)
        ranging = {*body.beams, *body.fans, *self.ros2.ranging}
        self.ranging = {s.signal for s in self._sensors.values() if s.name in ranging}

    def frames(self) -> Iterator[tuple[str, Pose3]]:
        """Frames of the sensors, and their poses on the body."""
        for sensor, fan in self._body.fans.items():
            middle = fan.yaw + fan.step * (fan.rays - 1) / 2.0
            yield self._names.frame(sensor), Pose3(fan.x, fan.y, 0.0, yaw=middle)
        for sensor, beams in self._body.beams.items():
            for name, beam in zip(self._beam_names(sensor), beams, strict=True):
                yield self._names.frame(name), Pose3(beam.x, beam.y, 0.0, pitch=-beam.elevation, yaw=beam.yaw)
        yield from self.ros2.frames()

    def take(self, event: ev.SensorRead) -> Iterable[Published]:
        """Messages with a reading."""
        if event.sensor not in self._converters:
            self._converters[event.sensor] = self._converter(event.sensor)
        return self._converters[event.sensor](event)

    def _converter(self, sensor: str) -> Convert:
        """Function that makes the messages of a sensor."""
        spec = self._sensors.get(sensor)
        driver = spec.driver if spec else ""
        if sensor in self.ros2:
            return self.ros2.take
        if sensor in self._body.fans:
            return self._scans(sensor, spec)
        if sensor in self._body.beams:
            return self._ranges(sensor)
        if driver == "gyro":
            topic, frame, kind = self._alone("imu", spec), self._names.frame(BASE), "sensor_msgs/msg/Imu"
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
        match spec.parameters.get("range") if spec else None:
            case (float(least), *_):
                return least, reach
        return 0.0, reach  # the keys of a driver of the user have any form

    def _beam_names(self, sensor: str) -> Sequence[str]:
        """Names of the beams of a sensor: its sites if known."""
        count, spec = len(self._body.beams[sensor]), self._sensors.get(sensor)
        sites = spec.parameters.get("sites", ()) if spec else ()
        return sites if len(sites) == count else [f"{sensor}{i}" for i in range(count)]

    def _scans(self, sensor: str, spec: SensorSpec | None) -> Convert:
        fan, frame = self._body.fans[sensor], self._names.frame(sensor)
        topic = "scan" if len(self._body.fans) == 1 else f"scan/{sensor}"
        first, limits = -fan.step * (fan.rays - 1) / 2.0, self._limits(sensor, fan.reach)
        times = (1.0 / spec.rate if spec and spec.rate else 0.0, spec.parameters.get("sweep", 0.0) if spec else 0.0)

        def convert(e: ev.SensorRead) -> Iterator[Published]:
            ranges = e.values
            if len(ranges) == fan.rays:
                at, step = self._names.start + e.stamp, fan.step
                fields = messages.laser_scan(at, frame, ranges, first=first, step=step, limits=limits, times=times)
                yield self._names.published(topic, e.t, "sensor_msgs/msg/LaserScan", fields)

        return convert

    def _ranges(self, sensor: str) -> Convert:
        beams, names = self._body.beams[sensor], self._beam_names(sensor)
        known = [(beam, name, self._limits(sensor, beam.reach)) for beam, name in zip(beams, names, strict=True)]

        def convert(e: ev.SensorRead) -> Iterator[Published]:
            at = self._names.start + e.stamp
            for (beam, name, limits), value in zip(known, e.values, strict=False):
                fields = messages.sonar_range(at, self._names.frame(name), value, opening=beam.cone, limits=limits)
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
