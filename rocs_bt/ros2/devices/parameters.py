"""Keys of sensors and actuators with `driver = "ros2"` in robot.toml, and the values that each message type offers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ...base.errors import Fault, InputError, unknown
from ...base.units import Metres, Radians
from ..messages.field_path import FieldPath
from ..network.qos import QoS
from ..settings import name_faults

SCAN = "sensor_msgs/msg/LaserScan"
RANGE = "sensor_msgs/msg/Range"
JOINTS = "sensor_msgs/msg/JointState"
NUMBER = "std_msgs/msg/Float64"
STRING = "std_msgs/msg/String"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
TWIST = "geometry_msgs/msg/Twist"
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"
ARRAY = "std_msgs/msg/Float64MultiArray"

_POSE = {"position": 3, "orientation": 1, "attitude": 2, "height": 1}

TAKES: Mapping[str, Mapping[str, int | None]] = {
    SCAN: {"ranges": None},
    RANGE: {"range": 1},
    "sensor_msgs/msg/Imu": {"turn_rate": 1, "orientation": 1, "attitude": 2, "acceleration": 3},
    "nav_msgs/msg/Odometry": {**_POSE, "twist": 4},
    JOINTS: {"velocity": None, "position": None, "effort": None},
    "geometry_msgs/msg/PoseWithCovarianceStamped": {**_POSE, "spread": 1},
    "geometry_msgs/msg/PoseStamped": _POSE,
    "sensor_msgs/msg/BatteryState": {"percentage": 1, "voltage": 1, "current": 1},
    DIAGNOSTICS: {"level": 1},
    "std_msgs/msg/Bool": {"data": 1},
    NUMBER: {"data": 1},
    STRING: {"word": 1},
    TRANSFORMS: _POSE,
}
"""Values that can be taken from messages of each type with a short form; the first by default.

Each has its number of numbers; None if other keys declare this number.
"""

ACTUATOR_TYPES = (TWIST, TWIST_STAMPED, ARRAY)
"""Message types of actuators."""

STAMPS = ("source", "header")
ZEROS = ("minimum", "no_echo", "invalid")
NANS = ("invalid", "no_echo")

MAX_RAYS = 4000
"""Maximum number of rays that are taken from a scan."""


@dataclass(frozen=True, kw_only=True)
class Ros2SensorParameters:
    """Sensor that reads a topic of ROS 2.

    Attributes:
        type: Message type, such as `sensor_msgs/msg/LaserScan`.
        topic: Name of the topic; a relative one is in the namespace of the `[ros2]` table.
        topics: Names of several topics of the same type, in place of `topic`; their values are concatenated.
        take: Value that is taken from a message with a short form (`TAKES`); by default the first.
        values: Paths to fields, such as `pose.pose.position.x`, in place of `take`.
        length: Number of values of a message, for `values` with an array of variable length; by default that of the
            first message.
        reliability: Requested reliability: `reliable` or `best_effort`.
        durability: Requested durability: `volatile`, or `transient_local` for a latched topic.
        depth: Number of messages that are kept.
        stamp: Time of a reading: `source` (when the message was published; the clocks of both computers must agree),
            or `header` (the stamp in the message, by the same clock).
        rays: Number of rays that a scan is reduced to; each has the smallest range of its sector.
        span: Angle from the first to the last of these rays, centred ahead [rad].
        zero: Meaning of the range 0 in a LaserScan or Range: `minimum` (an obstacle at the minimum range), `no_echo` or
            `invalid`.
        nan: Meaning of the range NaN in a LaserScan or Range: `invalid` (a fault), or `no_echo` as for many drivers.
        joints: Names of the joints, in the order of the values.
        wheel_radius: Factor of joint values, so that wheels have linear speeds [m].
        words: Texts, of which a String has one: the value is the index; another text is NaN.
        status: Part of the name of the diagnostics that count; all if empty.
        frame: Frame of a pose from transforms.
        child: Frame of the robot.
    """

    type: str
    topic: str = ""
    topics: tuple[str, ...] = ()
    take: str = ""
    values: tuple[str, ...] = ()
    length: int = 0
    reliability: str = ""
    durability: str = "volatile"
    depth: int = 5
    stamp: str = "source"
    rays: int = 0
    span: Radians = 0.0
    zero: str = "minimum"
    nan: str = "invalid"
    joints: tuple[str, ...] = ()
    wheel_radius: Metres = 1.0
    words: tuple[str, ...] = ()
    status: str = ""
    frame: str = "map"
    child: str = "base_link"

    def __post_init__(self) -> None:
        faults = [fault for topic in self.all_topics for fault in name_faults("topic", topic)]
        if bool(self.topic) == bool(self.topics):
            faults.append(Fault("one of topic and topics is needed.", hint='Write topic = "scan".'))
        faults += self._take_faults()
        if self.stamp not in STAMPS:
            faults.append(unknown("stamp", self.stamp, STAMPS))
        if self.zero not in ZEROS:
            faults.append(unknown("meaning of zero", self.zero, ZEROS))
        if self.nan not in NANS:
            faults.append(unknown("meaning of NaN", self.nan, NANS))
        if (self.zero, self.nan) != (ZEROS[0], NANS[0]) and (self.type not in (SCAN, RANGE) or self.values):
            faults.append(Fault("zero and nan are for the short forms of LaserScan and Range.", hint="Omit them."))
        try:
            self.qos  # noqa: B018 - checks the policies
            for path in self.values:
                FieldPath(path)
        except InputError as error:
            faults += error.faults
        if faults:
            raise InputError(*faults)

    def _take_faults(self) -> list[Fault]:
        takes = TAKES.get(self.type)
        if takes is None and not self.values:
            hint = f'Write values = ["a.b", "c[0]"]. Types with a short form: {", ".join(TAKES)}.'
            return [Fault(f"'{self.type}' has no short form: values is needed.", hint=hint)]
        faults = []
        if self.take and self.values:
            faults.append(Fault("take and values exclude each other."))
        if self.length < 0 or (self.length and not self.values):
            faults.append(Fault("length is for values, and positive.", hint='Write values = ["data"] and length = 4.'))
        if self.take and takes is not None and self.take not in takes:
            faults.append(unknown("value to take", self.take, takes, f"'{self.type}'"))
        sound = 2 <= self.rays <= MAX_RAYS and 0.0 < self.span <= math.tau
        if self.type == SCAN and not self.values and not sound:
            found = f"{self.rays} and {math.degrees(self.span):.4g} deg"
            message = f"a scan needs rays (2 to {MAX_RAYS}) and span (up to 360 deg), found {found}."
            faults.append(Fault(message, hint='Write rays = 360 and span = "359 deg".'))
        if self.type == JOINTS and not self.joints and not self.values:
            faults.append(Fault("joints is needed, the names of the joints.", hint='Write joints = ["left", "right"].'))
        if self.type == STRING and not self.words and not self.values:
            faults.append(Fault("words is needed, the texts that the topic can have."))
        return faults

    @property
    def all_topics(self) -> tuple[str, ...]:
        """Names of all topics."""
        return self.topics or ((self.topic,) if self.topic else ())

    @property
    def qos(self) -> QoS:
        """Requested quality of service; transforms are reliable by default, all others best effort."""
        default = "reliable" if self.type == TRANSFORMS else "best_effort"
        depth = max(self.depth, 100) if self.type == TRANSFORMS else self.depth
        return QoS(self.reliability or default, self.durability, depth)

    @property
    def taken(self) -> str:
        """Value that is taken from a message; empty if `values` lists fields."""
        return "" if self.values else self.take or next(iter(TAKES[self.type]))

    def scale(self, declared: float) -> float:
        """Factor from the numbers of a message to the values of a reading.

        `unit` is the unit of fields (`values`) and of a Float64; all other short forms are in SI by definition.
        """
        return declared if self.values or self.type == NUMBER else 1.0

    @property
    def size(self) -> int | None:
        """Number of values of a reading; None if it depends on the messages."""
        if self.values:
            return self.length * len(self.all_topics) or None
        own = {SCAN: self.rays, JOINTS: len(self.joints)}
        each = own.get(self.type, TAKES[self.type][self.taken])
        return None if each is None else each * len(self.all_topics)


@dataclass(frozen=True, kw_only=True)
class Ros2ActuatorParameters:
    """Actuator that publishes its commands on a topic of ROS 2.

    A twist is that of the robot's locomotion for the command, so wheels keep their limits.

    Attributes:
        topic: Name of the topic; a relative one is in the namespace of the `[ros2]` table.
        type: Message type: Twist or TwistStamped; or Float64MultiArray with the values of the command itself.
        frame: Frame of a TwistStamped.
        scale: Factor of the values of a Float64MultiArray, such as 1 / wheel radius.
        reliability: Offered reliability: `reliable` or `best_effort`.
        depth: Number of messages that are kept.
    """

    topic: str
    type: str = TWIST_STAMPED
    frame: str = "base_link"
    scale: float = 1.0
    reliability: str = "reliable"
    depth: int = 1

    def __post_init__(self) -> None:
        faults = name_faults("topic", self.topic)
        if self.type not in ACTUATOR_TYPES:
            faults.append(unknown("message type of actuators", self.type, ACTUATOR_TYPES))
        if not (math.isfinite(self.scale) and self.scale != 0.0):
            faults.append(Fault(f"scale must be finite and not 0, found {self.scale:g}."))
        try:
            self.qos  # noqa: B018 - checks the policies
        except InputError as error:
            faults += error.faults
        if faults:
            raise InputError(*faults)

    @property
    def qos(self) -> QoS:
        """Offered quality of service."""
        return QoS(self.reliability, "volatile", self.depth)

    @property
    def size(self) -> int | None:
        """Number of values of a command: None, because the locomotion declares it."""
        return None
