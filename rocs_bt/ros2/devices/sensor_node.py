"""SensorNode: sensor that reads topics of ROS 2 (paper, section 7 and Figure 10)."""

from __future__ import annotations

import math
from typing import Any, Protocol

from ...base.errors import DeviceError
from ...base.geometry import Pose3
from ...interfaces.device import Reading, Sensor
from ..messages.frames import Frames
from ..messages.message_types import TRANSFORMS
from ..messages.takes import POSE_TAKES
from ..network.matching import OwnEndpoint
from ..network.node import MAX_AHEAD, RosNode, header_stamp
from ..network.qos import QoS
from ..network.transport import Reader, Sample
from .parameters import Ros2SensorParameters


class SensorNode(Sensor):
    """Sensor that polls one or more topics; only the newest message of each counts.

    A topic that stops repeats its last reading with the old stamp, so that its signals become stale. Malformed
    messages, wrong sizes and absurd stamps are counted (`RosNode.faults`) and raise DeviceError.

    Args:
        name: Name of the sensor in robot.toml.
        node: Connection of the robot.
        parameters: Keys of the sensor.
        scale: Factor from the unit of the values to SI.
        max_age: Validity of a reading [s]; a stamp further in the future is a fault, too.

    Raises:
        InputError: The message type is unknown, or lacks a field.
        DeviceError: The network refuses the subscription.
    """

    def __init__(
        self,
        name: str,
        node: RosNode,
        parameters: Ros2SensorParameters,
        scale: float = 1.0,
        max_age: float = math.inf,
    ) -> None:
        super().__init__(name)
        self._node = node
        source = _Transforms if parameters.type == TRANSFORMS else _Topic
        stamps = [_Stamps(node, parameters.stamp == "header", min(max_age, MAX_AHEAD)) for _ in parameters.all_topics]
        self._sources: list[_Source] = [
            source(node, topic, parameters, scale, each)
            for topic, each in zip(parameters.all_topics, stamps, strict=True)
        ]
        self._stamps = stamps
        self._newest: list[Reading | None] = [None] * len(self._sources)
        self._faults: list[str] = [""] * len(self._sources)  # of the last messages
        self._qos = parameters.qos

    @property
    def clock_ahead(self) -> float:
        return max(each.ahead for each in self._stamps)

    @property
    def topics(self) -> list[str]:
        """Full names of the topics."""
        return [source.reader.topic for source in self._sources]

    def read(self) -> Reading:
        fault: DeviceError | None = None
        for i, source in enumerate(self._sources):
            try:
                if (newest := source.newest()) is not None:
                    self._newest[i], self._faults[i] = newest, ""
            except DeviceError as error:
                fault, self._faults[i] = error, str(error)
        if fault is not None:
            raise fault
        readings = [reading for reading in self._newest if reading is not None]
        if len(readings) < len(self._sources):
            i = self._newest.index(None)
            reader = self._sources[i].reader
            own = OwnEndpoint(reader.topic, reader.type, self._qos)
            raise DeviceError(self._faults[i] or self._node.why_silent(own))
        if len(readings) == 1:
            return readings[0]
        return Reading(min(r.stamp for r in readings), [value for r in readings for value in r.values])

    def close(self) -> None:
        for source in self._sources:
            source.close()


class _Source(Protocol):
    """Source of readings from one topic."""

    reader: Reader

    def newest(self) -> Reading | None:
        """Reading of the newest message; None if none has arrived since the last call. Raises DeviceError."""

    def close(self) -> None:
        """Close the subscriptions."""


class _Stamps:
    """Times of the messages of one topic.

    Args:
        node: Connection of the robot.
        header: Whether the time is that in the header.
        max_ahead: Time by which a stamp may be in the future [s].

    Attributes:
        in_headers: Whether the time is that in the header, also because the robot is simulated.
        ahead: Time by which the newest stamp was in the future [s].
    """

    def __init__(self, node: RosNode, header: bool, max_ahead: float) -> None:
        self.in_headers = header or node.settings.use_sim_time
        self.ahead = 0.0
        self._node = node
        self._header = header
        self._max_ahead = max_ahead

    def of(self, reader: Reader, sample: Sample, message: Any) -> float:
        """Time of a message on the clock of the run [s]; raises DeviceError."""
        node, header = self._node, hasattr(message, "header")
        try:
            if node.settings.use_sim_time and not self._header and not header:
                return node.received()  # the time at which it was published is not simulated
            use_header = self._header or (node.settings.use_sim_time and header)
            stamp = header_stamp(message) if use_header else sample.stamp
            time, self.ahead = node.stamp(stamp, self._max_ahead)
        except DeviceError as error:
            raise node.fault(reader.topic, "stamp", error) from error
        return time


class _Topic:
    """Values of the messages of one topic."""

    def __init__(self, node: RosNode, topic: str, given: Ros2SensorParameters, scale: float, stamps: _Stamps) -> None:
        self._node = node
        self._given = given
        self._scale = scale
        self._stamps = stamps
        self._take = given.make_take(node.types)
        self._silent = True  # whether no message was about the sensor's values
        self._every = given.form is not None and given.form.parts
        self._size = given.message_size(node.types)
        self.reader = node.reader(topic, given.type, given.qos)

    def newest(self) -> Reading | None:
        newest = self.reader.take_all() if self._every else [self.reader.take()]
        found: Reading | None = None
        for sample in newest:
            found = (None if sample is None else self._reading(sample)) or found
        self._silent = self._silent and found is None
        if self._silent and newest and self._every:
            joints = ", ".join(self._given.joints)
            raise DeviceError(f"{self.reader.topic}: no message so far is about {joints}")
        return found

    def _reading(self, sample: Sample) -> Reading | None:
        """Reading of a message; None if the message is not about the sensor's values."""
        message = _message(self._node, self.reader, sample)
        try:
            values = self._take(message)
        except DeviceError as error:
            raise self._node.fault(self.reader.topic, "values", error) from error
        if not values and self._every:
            return None
        if self._size is None:
            self._size = len(values)
        if len(values) != self._size:
            wrong = DeviceError(f"it has {len(values)} values, not {self._size}")
            raise self._node.fault(self.reader.topic, "size", wrong)
        if any(map(math.isnan, values)):
            self._node.fault(self.reader.topic, "NaN", DeviceError("NaN"))
        scaled = values if self._scale == 1.0 else [self._scale * value for value in values]
        return Reading(self._stamps.of(self.reader, sample, message), scaled)

    def close(self) -> None:
        self.reader.close()


class _Transforms:
    """Pose of the robot through the transforms of a topic, and of the latched topic with `_static` in its name."""

    def __init__(self, node: RosNode, topic: str, given: Ros2SensorParameters, scale: float, stamps: _Stamps) -> None:
        self._node = node
        self._given = given
        self._stamps = stamps
        self._take = POSE_TAKES[given.taken]
        self._frames = Frames()
        self._size = given.size
        self.reader = node.reader(topic, TRANSFORMS, given.qos)
        static = QoS("reliable", "transient_local", given.qos.depth)
        self._static = node.reader(f"{topic}_static", TRANSFORMS, static)

    def newest(self) -> Reading | None:
        for sample in self._static.take_all():
            self._add(self._static, sample, math.inf)
        newest, fault = None, None
        for sample in self.reader.take_all():
            try:
                newest = self._add(self.reader, sample)
            except DeviceError as error:  # the other messages count
                fault = error
        if newest is None:
            if fault is not None:
                raise fault
            return None
        try:
            place, rotation, stamp = self._frames.pose(self._given.frame, self._given.child)
        except DeviceError as error:
            raise DeviceError(f"{self.reader.topic}: {error}") from error
        return Reading(min(stamp, newest), self._take(Pose3.from_quaternion(place, rotation)))

    def close(self) -> None:
        self.reader.close()
        self._static.close()

    def _add(self, reader: Reader, sample: Sample, stamp: float | None = None) -> float:
        """Add the transforms of a message; returns their stamp [s], by default that of the message."""
        message = _message(self._node, reader, sample)
        if stamp is None:
            stamp = self._stamp(message, sample)
        try:
            self._frames.add(message, stamp)
        except DeviceError as error:
            raise self._node.fault(reader.topic, "values", error) from error
        return stamp

    def _stamp(self, message: Any, sample: Sample) -> float:
        """Time of the transforms of a message on the clock of the run [s].

        Localisations date transforms ahead, so a stamp in a header is at most the present time.
        """
        node = self._node
        if not (message.transforms and self._stamps.in_headers):
            return self._stamps.of(self.reader, sample, message)
        try:
            oldest = min(header_stamp(each) for each in message.transforms)
            return node.stamp(min(oldest, node.now()))[0]
        except DeviceError as error:
            raise node.fault(self.reader.topic, "stamp", error) from error


def _message(node: RosNode, reader: Reader, sample: Sample) -> Any:
    try:
        return node.types.deserialize(sample.data, reader.type)
    except DeviceError as error:
        raise node.fault(reader.topic, "malformed", error) from error
