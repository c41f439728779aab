"""Fields of standard messages, as nested mappings for `TypeStore.make`. SI units, frames of REP 103 and REP 105."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...base.geometry import Pose3, Twist3

Fields = dict[str, Any]

UNMEASURED = 1e6
"""Variance of a quantity that nothing measures, which filters then ignore, SI units."""


def time_fields(t: float) -> Fields:
    """Fields of a builtin_interfaces/msg/Time, to the nearest nanosecond."""
    seconds, nanoseconds = divmod(round(t * 1e9), 1_000_000_000)
    return {"sec": seconds, "nanosec": nanoseconds}


def seconds_of(time: Any) -> float:
    """Time of a builtin_interfaces/msg/Time [s]."""
    return float(time.sec) + 1e-9 * float(time.nanosec)


def clock(t: float) -> Fields:
    """Fields of a rosgraph_msgs/msg/Clock."""
    return {"clock": time_fields(t)}


def diagonal(variances: Sequence[float]) -> list[float]:
    """Covariance of n quantities with independent errors, shape (n * n,) in rows."""
    size = len(variances)
    return [variances[row] if row == column else 0.0 for row in range(size) for column in range(size)]


def twist_stamped(stamp: float, frame: str, twist: Twist3) -> Fields:
    """Fields of a geometry_msgs/msg/TwistStamped: velocity of the body with this frame."""
    return {"header": header(stamp, frame), "twist": twist_fields(twist)}


def transform(stamp: float, frame: str, child: str, pose: Pose3) -> Fields:
    """Fields of a geometry_msgs/msg/TransformStamped: the pose of the frame `child` in `frame`."""
    turned = {"translation": vector(*pose[:3]), "rotation": quaternion(pose)}
    return {"header": header(stamp, frame), "child_frame_id": child, "transform": turned}


def transforms(parts: Sequence[Mapping[str, Any]]) -> Fields:
    """Fields of a tf2_msgs/msg/TFMessage."""
    return {"transforms": list(parts)}


def pose_fields(pose: Pose3) -> Fields:
    """Fields of a geometry_msgs/msg/Pose."""
    return {"position": vector(*pose[:3]), "orientation": quaternion(pose)}


def twist_fields(twist: Twist3) -> Fields:
    """Fields of a geometry_msgs/msg/Twist."""
    return {"linear": vector(twist.forward, twist.left, twist.up), "angular": vector(0.0, 0.0, twist.turn)}


def twist_of(message: Any) -> Twist3:
    """Velocity of a body from a Twist or TwistStamped message; the turn rates about x and y are ignored."""
    twist = getattr(message, "twist", message)
    linear = twist.linear
    return Twist3(linear.x, linear.y, linear.z, twist.angular.z)


def header(stamp: float, frame: str) -> Fields:
    """Fields of a std_msgs/msg/Header."""
    return {"stamp": time_fields(stamp), "frame_id": frame}


def vector(x: float, y: float, z: float) -> Fields:
    """Fields of a Point or Vector3."""
    return {"x": x, "y": y, "z": z}


def quaternion(pose: Pose3) -> Fields:
    """Fields of a Quaternion: the orientation of a pose."""
    w, x, y, z = pose.quaternion
    return {"x": x, "y": y, "z": z, "w": w}
