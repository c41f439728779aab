"""Keys of sensors and actuators with `driver = "ros2"` in robot.toml."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Literal

from ...base.errors import Fault, InputError, did_you_mean
from ...base.units import ANGLE, Bounds, Metres
from ...declare import Key, OneOf, Valid, Value, Wrong
from ..messages.field_path import field_at, numbers_at, parse_path
from ..messages.known_types import KnownTypes
from ..messages.message_types import MESSAGES, TRANSFORMS, MessageType
from ..messages.takes import Take
from ..messages.type_store import TypeStore
from ..network.qos import QoS
from ..settings import NAME_HINT, is_ros_name

TWIST = "geometry_msgs/msg/Twist"
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"
ARRAY = "std_msgs/msg/Float64MultiArray"

ACTUATOR_TYPES = (TWIST, TWIST_STAMPED, ARRAY)
"""Message types of actuators."""

_Topic = Annotated[str, Valid(is_ros_name, "a valid topic", NAME_HINT)]
_Depth = Annotated[int, Bounds(1)]

MAX_RAYS = 4000
"""Maximum number of rays that are taken from a scan."""


class Ros2SensorParameters(Value):
    """Sensor that reads a topic of ROS 2.

    Attributes:
        type: Message type, such as `sensor_msgs/msg/LaserScan`.
        topic: Name of the topic; a relative one is in the namespace of the `[ros2]` table.
        topics: Names of several topics of the same type, in place of `topic`; their values are concatenated.
        take: Value that is taken from a message with a short form (`MESSAGES`); by default the first.
        paths: Key `values`: paths to fields, such as `pose.pose.position.x`, in place of `take`.
        length: Number of values of a message, for `paths` with an array of variable length; by default that of the
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
    topic: _Topic = ""
    topics: tuple[_Topic, ...] = ()
    take: str = ""
    paths: Annotated[tuple[str, ...], Key("values")] = ()
    length: Annotated[int, Bounds(0)] = 0
    reliability: Literal["", "reliable", "best_effort"] = ""
    durability: Literal["volatile", "transient_local"] = "volatile"
    depth: _Depth = 5
    stamp: Literal["source", "header"] = "source"
    rays: Annotated[int, Bounds(0, MAX_RAYS)] = 0
    span: Annotated[float, ANGLE, Bounds(0.0, math.tau)] = 0.0
    zero: Literal["minimum", "no_echo", "invalid"] = "minimum"
    nan: Literal["invalid", "no_echo"] = "invalid"
    joints: tuple[str, ...] = ()
    wheel_radius: Metres = 1.0
    words: tuple[str, ...] = ()
    status: str = ""
    frame: str = "map"
    child: str = "base_link"

    def _check(self) -> Iterator[Wrong]:
        """Faults of keys that exclude or need each other, and of what cannot be taken from the messages."""
        if bool(self.topic) == bool(self.topics):
            yield Wrong(None, "one of topic and topics is needed.", 'Write topic = "scan".')
        if self.paths and self.take:
            yield Wrong("take", "take and values exclude each other.")
        if self.length and not self.paths:
            yield Wrong("length", "length is for values.", 'Write values = ["data"] and length = 4.')
        for key, default in (("zero", "minimum"), ("nan", "invalid")):
            if (self.form or self.paths) and getattr(self, key) != default and key not in self.keys:
                types = " and ".join(m.type.rpartition("/")[2] for m in MESSAGES.values() if key in m.keys)
                yield Wrong(key, f"{key} is for the short forms of {types}.", "Omit it.")
        for path in self.paths:
            try:
                whole = not parse_path(path)
            except InputError as error:
                yield from (Wrong("values", fault.message, fault.hint) for fault in error.faults)
            else:
                if whole:
                    yield Wrong("values", f"'{path}' is the whole message, not a field.", "Write 'a.b' or 'c[0]'.")
        if not self.paths:
            yield from self._short_form()

    def _short_form(self) -> Iterator[Wrong]:
        if self.form is None:
            hint = f'Write values = ["a.b", "c[0]"]. Types with a short form: {", ".join(MESSAGES)}.'
            yield Wrong("type", f"'{self.type}' has no short form: values is needed.", hint)
        elif self.take and self.take not in self.form.sizes:
            hint = did_you_mean(self.take, self.form.sizes, f"'{self.type}'")
            yield Wrong("take", f"no value to take is named '{self.take}'.", hint)
        if "rays" in self.keys and (self.rays < 2 or not self.span):
            found = f"{self.rays} and {math.degrees(self.span):.4g} deg"
            message = f"a scan needs rays (2 to {MAX_RAYS}) and span (up to 360 deg), found {found}."
            yield Wrong("rays" if self.rays else None, message, 'Write rays = 360 and span = "359 deg".')
        if "joints" in self.keys and not self.joints:
            yield Wrong(None, "joints is needed, the names of the joints.", 'Write joints = ["left", "right"].')
        if "words" in self.keys and not self.words:
            yield Wrong(None, "words is needed, the texts that the topic can have.")

    @property
    def form(self) -> MessageType | None:
        """Short form of the messages; None if `paths` lists fields, or there is none."""
        return None if self.paths else MESSAGES.get(self.type)

    @property
    def keys(self) -> Sequence[str]:
        """Keys of the short form."""
        return () if self.form is None else self.form.keys

    @property
    def pose_frame(self) -> str:
        """Frame of a pose: `corrected` by a localiser, or `continuous`, as of odometry (REP 105)."""
        transforms = self.type == TRANSFORMS and not self.frame.endswith("odom")
        corrected = transforms or "/PoseWithCovariance" in self.type or self.type.endswith("/PoseStamped")
        return "corrected" if corrected else "continuous"

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
        """Value that is taken from a message; empty if `paths` lists fields."""
        return "" if self.form is None else self.take or next(iter(self.form.sizes))

    def scale(self, declared: float) -> float:
        """Factor from the numbers of a message to the values of a reading, for that of the sensor's `unit`.

        `unit` is the unit of fields (`paths`) and of a Float64; all other short forms are in SI by definition.
        """
        if self.form is None or self.form.scale == "unit":
            return declared
        return float(getattr(self, self.form.scale)) if self.form.scale else 1.0

    @property
    def size(self) -> int | None:
        """Number of values of a reading; None if it depends on the messages."""
        if self.form is None:
            return self.length * len(self.all_topics) or None
        each = self.form.sizes[self.taken]
        if isinstance(each, str):
            declared = getattr(self, each)
            each = int(declared) if isinstance(declared, int) else len(declared)
        return each * len(self.all_topics)

    def message_size(self, types: TypeStore) -> int | None:
        """Number of values of a message, by the declarations in robot.toml and of the message type; None without one.

        Raises:
            InputError: `length` is not the number of values of the fields.
        """
        if self.size is not None and not self.paths:
            return self.size // len(self.all_topics)
        fields = [field_at(KnownTypes(types), self.type, parse_path(text)) for text in self.paths]
        sizes = [None if field is None else field.size if field.array else 1 for field in fields]
        known, fixed = sum(size or 0 for size in sizes), None not in sizes
        if self.length and (self.length < known or (fixed and self.length != known)):
            raise InputError(Fault(f"length is {self.length}, but the fields of {self.type} have {known} values."))
        return self.length or (known if fixed else None)

    def make_take(self, types: TypeStore) -> Take:
        """Create the function that takes the sensor's values from messages.

        Raises:
            InputError: The message type is unknown, or lacks a field.
        """
        types.message(self.type)
        if self.form is not None:
            return self.form.take(self.taken, **{key: getattr(self, key) for key in self.form.keys})
        paths = [parse_path(text) for text in self.paths]
        for path in paths:
            field_at(KnownTypes(types), self.type, path)
        return lambda message: [value for path in paths for value in numbers_at(message, path)]


class Ros2ActuatorParameters(Value):
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

    topic: _Topic
    type: Annotated[str, OneOf(ACTUATOR_TYPES)] = TWIST_STAMPED
    frame: str = "base_link"
    scale: float = 1.0
    reliability: Literal["reliable", "best_effort"] = "reliable"
    depth: _Depth = 1

    def _check(self) -> Iterator[Wrong]:
        """Fault of a factor that no command would pass."""
        if self.scale == 0.0:
            yield Wrong("scale", "scale must be finite and not 0, found 0.")

    @property
    def qos(self) -> QoS:
        """Offered quality of service."""
        return QoS(self.reliability, "volatile", self.depth)

    @property
    def size(self) -> int | None:
        """Number of values of a command: None, because the locomotion declares it."""
        return None
