"""Table of message types, `MESSAGES`: the values that a sensor takes from a message, and how one is made of them.

Sensors with `driver = "ros2"` and replays of bags take; `rocs-bt sim` and exports of bags make.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from ...base.geometry import Pose3, Twist3
from . import fields
from .fields import Fields, header
from .frames import Frames
from .names import BASE, MAP, ODOM
from .takes import (
    POSE_TAKES,
    ScanReducer,
    Take,
    WorstLevel,
    take_imu,
    take_joints,
    take_number,
    take_pose,
    take_range,
    take_spread,
    take_twist,
    take_word,
)

SCAN = "sensor_msgs/msg/LaserScan"
RANGE = "sensor_msgs/msg/Range"
IMU = "sensor_msgs/msg/Imu"
ODOMETRY = "nav_msgs/msg/Odometry"
JOINTS = "sensor_msgs/msg/JointState"
POSE_FIX = "geometry_msgs/msg/PoseWithCovarianceStamped"
POSE = "geometry_msgs/msg/PoseStamped"
TRANSFORMS = "tf2_msgs/msg/TFMessage"

Values = Mapping[str, Sequence[float]]
"""Values by what is taken, such as `orientation`; SI units."""


@dataclass(frozen=True)
class Channel:
    """Constant facts about the values of a topic.

    Attributes:
        frame: Frame of the values.
        child: Frame of the body.
        first: Direction of the first ray, left positive [rad].
        step: Angle from a ray to the next [rad].
        limits: Minimum and maximum range [m].
        times: Time between scans, and from the first ray of a scan to the last [s].
        opening: Opening angle of a beam [rad].
        names: Names of the joints, or of the status of each level.
        words: Texts of a String.
        covariances: Covariances by field, in rows; zeros where they are unknown.
    """

    frame: str = ""
    child: str = ""
    first: float = 0.0
    step: float = 0.0
    limits: Sequence[float] = (0.0, math.inf)
    times: tuple[float, float] = (0.0, 0.0)
    opening: float = 0.0
    names: Sequence[str] = ()
    words: Sequence[str] = ()
    covariances: Mapping[str, Sequence[float]] = field(default_factory=dict)


@dataclass(frozen=True)
class MessageType:
    """Message type with a short form.

    Attributes:
        type: Name of the type.
        sizes: Values that can be taken, the first by default: number of numbers, or the key that declares it.
        take: Creates the function from a message to values, for what is taken and the values of `keys`.
        make: Fields of the message at a stamp [s] with values, on a channel.
        keys: Keys in robot.toml of sensors that take from this type.
        scale: Key with the factor from the numbers of a message to the values of a reading.
        frame: Frame of the values by REP 105; empty if the type has none.
        parts: Whether several nodes publish parts of the whole, with a name for each value.
    """

    type: str
    sizes: Mapping[str, int | str]
    take: Callable[..., Take]
    make: Callable[[float, Values, Channel], Fields]
    keys: Sequence[str] = ()
    scale: str = ""
    frame: str = ""
    parts: bool = False


def pose_values(pose: Pose3) -> Values:
    """Values of a pose."""
    return {"position": pose[:3], "attitude": pose[3:5], "orientation": pose[5:]}


def _pose(v: Values) -> Pose3:
    x, y, z = v.get("position", (0.0, 0.0, 0.0))
    (z,), (roll, pitch) = v.get("height", (z,)), v.get("attitude", (0.0, 0.0))
    return Pose3(x, y, z, roll, pitch, *v.get("orientation", (0.0,)))


def _scan(t: float, v: Values, c: Channel) -> Fields:
    steps = len(v["ranges"]) - 1
    return {
        "header": header(t, c.frame),
        "angle_min": c.first,
        "angle_max": c.first + c.step * steps,
        "angle_increment": c.step,
        "time_increment": c.times[1] / max(steps, 1),
        "scan_time": c.times[0],
        "range_min": c.limits[0],
        "range_max": c.limits[1],
        "ranges": v["ranges"],
    }


def _range(t: float, v: Values, c: Channel) -> Fields:
    return {
        "header": header(t, c.frame),
        "radiation_type": 0,
        "field_of_view": c.opening,  # ULTRASOUND
        "min_range": c.limits[0],
        "max_range": c.limits[1],
        "range": v["range"][0],
    }


def _imu(t: float, v: Values, c: Channel) -> Fields:
    """An Imu, with what was not measured marked as unknown."""
    made: Fields = {"header": header(t, c.frame)}
    if v.keys() & {"orientation", "attitude"}:
        made["orientation"] = fields.quaternion(_pose(v))
    if "turn_rate" in v:
        made["angular_velocity"] = fields.vector(0.0, 0.0, *v["turn_rate"])
    if "acceleration" in v:
        made["linear_acceleration"] = fields.vector(*v["acceleration"])
    for name in ("orientation", "angular_velocity", "linear_acceleration"):
        unknown = [0.0 if name in made else -1.0, *[0.0] * 8]
        made[f"{name}_covariance"] = c.covariances.get(name, unknown)
    return made


def _odometry(t: float, v: Values, c: Channel) -> Fields:
    pose, twist = fields.pose_fields(_pose(v)), fields.twist_fields(Twist3(*v.get("twist", (0.0,))))
    made: Fields = {"pose": {"pose": pose}, "twist": {"twist": twist}}
    for name, covariance in c.covariances.items():
        made[name]["covariance"] = covariance
    return {"header": header(t, c.frame), "child_frame_id": c.child, **made}


def _pose_fix(t: float, v: Values, c: Channel) -> Fields:
    spread = fields.diagonal([*[v["spread"][0] ** 2] * 3, 0.0, 0.0, 0.0] if "spread" in v else [0.0] * 6)
    pose = {"pose": fields.pose_fields(_pose(v)), "covariance": c.covariances.get("pose", spread)}
    return {"header": header(t, c.frame), "pose": pose}


def _battery(t: float, v: Values, c: Channel) -> Fields:
    names = ("voltage", "temperature", "current", "charge", "capacity", "design_capacity", "percentage")
    known = dict.fromkeys(names, math.nan) | {name: value for name, (value,) in v.items()}  # NaN: unmeasured
    return {"header": header(t, c.frame), **known, "present": True}


def _diagnostics(t: float, v: Values, c: Channel) -> Fields:
    status = [{"name": name, "level": int(level)} for name, level in zip(c.names, v["level"], strict=True)]
    return {"header": header(t, c.frame), "status": status}


def _transforms(taken: str, frame: str, child: str) -> Take:
    """Pose through the transforms of one message."""

    def take(message: object) -> list[float]:
        frames = Frames()
        frames.add(message, 0.0)
        return POSE_TAKES[taken](Pose3.from_quaternion(*frames.pose(frame, child)[:2]))

    return take


_POSE = {"position": 3, "orientation": 1, "attitude": 2, "height": 1}
_BATTERY = {"percentage": 1, "voltage": 1, "current": 1}
_ECHO = ("zero", "nan")

MESSAGES: Mapping[str, MessageType] = {
    message.type: message
    for message in (
        MessageType(
            SCAN, {"ranges": "rays"}, lambda taken, **keys: ScanReducer(**keys), _scan,
            keys=("rays", "span", *_ECHO), frame=BASE,
        ),
        MessageType(RANGE, {"range": 1}, lambda taken, **keys: take_range(**keys), _range, keys=_ECHO, frame=BASE),
        MessageType(
            IMU, {"turn_rate": 1, "orientation": 1, "attitude": 2, "acceleration": 3}, take_imu, _imu, frame=BASE,
        ),
        MessageType(
            ODOMETRY, {**_POSE, "twist": 4},
            lambda taken: take_twist if taken == "twist" else take_pose(taken, lambda m: m.pose.pose),
            _odometry, frame=ODOM,
        ),
        MessageType(
            JOINTS, {"velocity": "joints", "position": "joints", "effort": "joints"}, take_joints,
            lambda t, v, c: {"header": header(t, c.frame), "name": list(c.names), **v},
            keys=("joints",), scale="wheel_radius", parts=True,
        ),
        MessageType(
            POSE_FIX, {**_POSE, "spread": 1},
            lambda taken: take_spread if taken == "spread" else take_pose(taken, lambda m: m.pose.pose),
            _pose_fix, frame=MAP,
        ),
        MessageType(
            POSE, _POSE, lambda taken: take_pose(taken, lambda m: m.pose),
            lambda t, v, c: {"header": header(t, c.frame), "pose": fields.pose_fields(_pose(v))}, frame=MAP,
        ),
        MessageType("sensor_msgs/msg/BatteryState", _BATTERY, take_number, _battery),
        MessageType(
            "diagnostic_msgs/msg/DiagnosticArray", {"level": 1}, lambda taken, status: WorstLevel(status),
            _diagnostics, keys=("status",), parts=True,
        ),
        MessageType("std_msgs/msg/Bool", {"data": 1}, take_number, lambda t, v, c: {"data": bool(v["data"][0])}),
        MessageType(
            "std_msgs/msg/Float64", {"data": 1}, take_number, lambda t, v, c: {"data": v["data"][0]}, scale="unit",
        ),
        MessageType(
            "std_msgs/msg/String", {"word": 1}, lambda taken, words: take_word(words),
            lambda t, v, c: {"data": c.words[int(v["word"][0])]}, keys=("words",),
        ),
        MessageType(
            TRANSFORMS, _POSE, _transforms,
            lambda t, v, c: fields.transforms([fields.transform(t, c.frame, c.child, _pose(v))]),
            keys=("frame", "child"),
        ),
    )
}  # fmt: skip  # a row has two or three lines, so that the whole table can be read at once
"""Message types with a short form, by name."""
