"""Fields of standard messages, as nested mappings for `MessageTypes.make`. SI units, frames of REP 103 and REP 105."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...base.geometry import Pose3, Twist3

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

Fields = dict[str, Any]

UNMEASURED = 1e6
"""Variance of a quantity that nothing measures, which filters then ignore, SI units."""


def time_fields(t: float) -> Fields:
    """Fields of a builtin_interfaces/msg/Time, to the nearest nanosecond."""
    seconds, nanoseconds = divmod(round(t * 1e9), 1_000_000_000)
    return {"sec": seconds, "nanosec": nanoseconds}


def clock(t: float) -> Fields:
    """Fields of a rosgraph_msgs/msg/Clock."""
    return {"clock": time_fields(t)}


def laser_scan(
    stamp: float,
    frame: str,
    ranges: Sequence[float] | npt.NDArray[np.float32],
    *,
    first: float,
    step: float,
    limits: Sequence[float],
    times: tuple[float, float] = (0.0, 0.0),
) -> Fields:
    """Fields of a sensor_msgs/msg/LaserScan.

    Args:
        stamp: Time of the scan [s].
        frame: Frame of the scanner.
        ranges: Range of each ray [m], +inf without an echo, NaN if invalid, shape (n,).
        first: Direction of the first ray, left positive [rad].
        step: Angle from a ray to the next [rad].
        limits: Minimum and maximum range [m].
        times: Time between scans, and from the first ray of a scan to the last [s].
    """
    return {
        "header": header(stamp, frame),
        "angle_min": first,
        "angle_max": first + step * (len(ranges) - 1),
        "angle_increment": step,
        "time_increment": times[1] / max(len(ranges) - 1, 1),
        "scan_time": times[0],
        "range_min": limits[0],
        "range_max": limits[1],
        "ranges": ranges,
    }


def sonar_range(stamp: float, frame: str, distance: float, *, opening: float, limits: Sequence[float]) -> Fields:
    """Fields of a sensor_msgs/msg/Range of an ultrasonic sensor, along the x axis of its frame.

    Args:
        stamp: Time of the measurement [s].
        frame: Frame of the sensor.
        distance: Range [m], +inf without an echo.
        opening: Opening angle of the beam [rad].
        limits: Minimum and maximum range [m].
    """
    return {
        "header": header(stamp, frame),
        "radiation_type": 0,  # ULTRASOUND
        "field_of_view": opening,
        "min_range": limits[0],
        "max_range": limits[1],
        "range": distance,
    }


def odometry(
    stamp: float,
    frame: str,
    child: str,
    pose: Pose3,
    twist: Twist3,
    covariances: Sequence[Sequence[float]] = ((0.0,) * 36, (0.0,) * 36),
) -> Fields:
    """Fields of a nav_msgs/msg/Odometry.

    Args:
        stamp: Time of the pose [s].
        frame: Frame of the pose.
        child: Frame of the body, and of the twist.
        pose: Pose of the body.
        twist: Velocity of the body.
        covariances: Covariances of pose and twist, each 36 numbers in rows; zeros if they are unknown.
    """
    return {
        "header": header(stamp, frame),
        "child_frame_id": child,
        "pose": {"pose": pose_fields(pose), "covariance": covariances[0]},
        "twist": {"twist": twist_fields(twist), "covariance": covariances[1]},
    }


def pose_with_covariance(stamp: float, frame: str, pose: Pose3, covariance: Sequence[float]) -> Fields:
    """Fields of a geometry_msgs/msg/PoseWithCovarianceStamped.

    Args:
        stamp: Time of the pose [s].
        frame: Frame of the pose.
        pose: Measured pose.
        covariance: Covariance of x, y, z, roll, pitch, yaw: 36 numbers in rows.
    """
    return {"header": header(stamp, frame), "pose": {"pose": pose_fields(pose), "covariance": covariance}}


def diagonal(variances: Sequence[float]) -> list[float]:
    """Covariance of n quantities with independent errors, shape (n * n,) in rows."""
    size = len(variances)
    return [variances[row] if row == column else 0.0 for row in range(size) for column in range(size)]


def pose_stamped(stamp: float, frame: str, pose: Pose3) -> Fields:
    """Fields of a geometry_msgs/msg/PoseStamped."""
    return {"header": header(stamp, frame), "pose": pose_fields(pose)}


def twist_stamped(stamp: float, frame: str, twist: Twist3) -> Fields:
    """Fields of a geometry_msgs/msg/TwistStamped: velocity of the body with this frame."""
    return {"header": header(stamp, frame), "twist": twist_fields(twist)}


def imu(stamp: float, frame: str, turn_rate: float, covariance: Sequence[float] = (0.0,) * 9) -> Fields:
    """Fields of a sensor_msgs/msg/Imu of a gyro about z, marked as without orientation and acceleration.

    Args:
        stamp: Time of the measurement [s].
        frame: Frame of the gyro.
        turn_rate: Turn rate about z [rad/s].
        covariance: Covariance of the turn rates about x, y and z, 9 numbers in rows; zeros if unknown.
    """
    unknown = [-1.0, *[0.0] * 8]
    return {
        "header": header(stamp, frame),
        "orientation_covariance": unknown,
        "angular_velocity": vector(0.0, 0.0, turn_rate),
        "angular_velocity_covariance": covariance,
        "linear_acceleration_covariance": unknown,
    }


def joint_state(stamp: float, names: Sequence[str], positions: Sequence[float], velocities: Sequence[float]) -> Fields:
    """Fields of a sensor_msgs/msg/JointState.

    Args:
        stamp: Time of the state [s].
        names: Names of the joints.
        positions: Angles [rad], shape (n,).
        velocities: Angular speeds [rad/s], shape (n,).
    """
    return {"header": header(stamp, ""), "name": list(names), "position": positions, "velocity": velocities}


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
