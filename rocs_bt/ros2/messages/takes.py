"""Functions that take the values of a sensor from a message, in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ...base.errors import DeviceError
from ...base.geometry import Pose3
from .fields import seconds_of

Take = Callable[[Any], Sequence[float]]
"""Function from a message to the values of a reading; none if the message is not about them.

It raises DeviceError for a faulty message.
"""

Array = npt.NDArray[np.float64]

_MEANINGS = {"minimum": 0.0, "no_echo": math.inf, "invalid": math.nan}  # of the ranges 0 and NaN


class ScanReducer:
    """Reduces laser scans to a fixed number of rays, each with the smallest range of its sector.

    A range without an echo is +inf, one below the scanner's minimum is the minimum, and an invalid one is NaN. An
    invalid range does not hide an echo in its sector, but a sector without an echo is invalid if one of its beams is. A
    scan in which a sector has no beam is faulty.

    Args:
        rays: Number of rays.
        span: Angle from the first to the last ray, centred ahead [rad].
        zero: Meaning of the range 0: `minimum`, `no_echo` or `invalid`.
        nan: Meaning of the range NaN: `invalid` or `no_echo`.
    """

    def __init__(self, rays: int, span: float, zero: str = "minimum", nan: str = "invalid") -> None:
        self._zero, self._nan = _MEANINGS[zero], _MEANINGS[nan]
        self._rays = rays
        self._span = span
        self._known: tuple[float, float, int] = (math.nan, math.nan, 0)
        self._order = np.empty(0, dtype=np.intp)  # beams in the order of the rays
        self._starts = np.empty(0, dtype=np.intp)  # first beam of each ray in that order

    def __call__(self, message: Any) -> list[float]:
        """Ranges of the rays, from right to left [m], shape (rays,).

        Raises:
            DeviceError: The scan has no beam in the sector of a ray, or no plausible angles.
        """
        ranges = np.asarray(message.ranges, dtype=float)
        geometry = (float(message.angle_min), float(message.angle_increment), len(ranges))
        if geometry != self._known:
            self._assign(*geometry)
        low, high = float(message.range_min), float(message.range_max)
        ranges = np.where(ranges == 0.0, self._zero, np.where(np.isnan(ranges), self._nan, ranges))
        ranges = np.where(ranges > high, math.inf, np.where(ranges < low, low, ranges)) if high > low else ranges
        ordered = ranges[self._order]
        least = np.fmin.reduceat(ordered, self._starts)  # NaN only if all are
        unsure = np.isinf(least) & np.isnan(np.minimum.reduceat(ordered, self._starts))
        found: list[float] = np.where(unsure, math.nan, least).tolist()
        return found

    def _assign(self, first: float, step: float, count: int) -> None:
        """Assign the beams of a scan to the rays: each to the nearest, and the nearest to a ray without beams."""
        if not (math.isfinite(first) and math.isfinite(step) and step != 0.0 and count > 0):
            raise DeviceError(f"the scan has {count} beams, beginning at {first:g} rad in steps of {step:g} rad")
        spacing = self._span / (self._rays - 1)
        around = math.isclose(self._span + spacing, math.tau, rel_tol=1e-6)
        bearings = (first + step * np.arange(count) + math.pi) % math.tau - math.pi
        places = bearings / spacing + 0.5 * (self._rays - 1)  # in rays from the first one
        nearest = np.round(places).astype(np.intp)
        turn = math.tau / spacing
        if around:
            nearest %= self._rays
        used = np.flatnonzero((nearest >= 0) & (nearest < self._rays))
        owner = nearest[used]
        missing = np.setdiff1d(np.arange(self._rays), owner)
        reach = max(0.75, abs(step) / spacing)  # distance in rays to a beam that still serves
        for ray in missing.tolist():
            off = np.abs(places - ray)
            off = np.minimum(off, np.abs(off - turn))
            best = int(np.argmin(off))
            if off[best] > reach:
                bearing = math.degrees(ray * spacing - 0.5 * self._span)
                ends = sorted(math.degrees(a) for a in (first, first + step * (count - 1)))
                message = f"the scan covers {ends[0]:.0f} to {ends[1]:.0f} deg, not the ray at {bearing:.0f} deg"
                raise DeviceError(f"{message}: correct span in robot.toml")
            used, owner = np.append(used, best), np.append(owner, ray)
        order = np.argsort(owner, kind="stable")
        self._order = used[order]
        self._starts = np.searchsorted(owner[order], np.arange(self._rays))
        self._known = (first, step, count)


STALE = 5.0
"""Age at which a status of the diagnostics counts as stale [s]; they are usually published at 1 Hz."""


class WorstLevel:
    """Worst level of the diagnostics: 0 for OK, 1 for a warning, 2 for an error, 3 for stale.

    A status that its node does not publish any more is stale, by the stamps in the headers. Only statuses with `status`
    in their names count.
    """

    def __init__(self, status: str) -> None:
        self._status = status
        self._levels: dict[str, tuple[int, float]] = {}  # levels and stamps [s]

    def __call__(self, message: Any) -> list[float]:
        """Worst of the newest levels of all statuses."""
        now = seconds_of(message.header.stamp)
        for each in message.status:
            if self._status in each.name:
                level = each.level[0] if isinstance(each.level, bytes) else int(each.level)
                self._levels[each.name] = (level, now)
        return [float(max((3 if now - at > STALE else level for level, at in self._levels.values()), default=0))]


def take_range(zero: str, nan: str) -> Take:
    """Range of a Range message [m]; see `ScanReducer`."""

    def take(message: Any) -> list[float]:
        value, low, high = float(message.range), float(message.min_range), float(message.max_range)
        if value == 0.0 or math.isnan(value):
            value = _MEANINGS[zero if value == 0.0 else nan]
        if not math.isnan(value):
            value = math.inf if value > high > low else max(value, low)
        return [value]

    return take


def take_joints(field: str, joints: Sequence[str]) -> Take:
    """Values of joints from a field of a JointState; none from a message about others, such as those of an arm."""

    def take(message: Any) -> list[float]:
        values, names = getattr(message, field), list(message.name)
        if names and not set(names) & set(joints):
            return []
        if missing := [joint for joint in joints if joint not in names]:
            raise DeviceError(f"the message has no joint '{missing[0]}', but {', '.join(names) or 'none'}")
        if len(values) != len(names):
            raise DeviceError(f"{field} has {len(values)} values for {len(names)} joints")
        return [float(values[names.index(joint)]) for joint in joints]

    return take


def take_word(words: Sequence[str]) -> Take:
    """Index of the text of a String in `words`; NaN for another text."""
    return lambda message: [float(words.index(message.data)) if message.data in words else math.nan]


def take_number(field: str) -> Take:
    """Number of a field."""
    return lambda message: [float(getattr(message, field))]


def pose3(position: Any, orientation: Any) -> Pose3:
    """Pose from a Point or Vector3 and a Quaternion.

    Raises:
        DeviceError: The quaternion has no length, or a value is not finite.
    """
    q = [float(getattr(orientation, axis)) for axis in ("w", "x", "y", "z")]
    length = math.hypot(*q)
    if not (math.isfinite(length) and abs(length - 1.0) < 0.1):
        raise DeviceError(f"the orientation is no unit quaternion: {q}")
    return Pose3.from_quaternion(_xyz(position), [each / length for each in q])


POSE_TAKES: dict[str, Callable[[Pose3], list[float]]] = {
    "position": lambda pose: [pose.x, pose.y, pose.z],
    "orientation": lambda pose: [pose.yaw],
    "attitude": lambda pose: [pose.roll, pose.pitch],
    "height": lambda pose: [pose.z],
}
"""Values that can be taken from a pose."""


def take_pose(taken: str, inner: Callable[[Any], Any]) -> Take:
    """Value of the Pose that a function finds in a message."""
    return lambda message: POSE_TAKES[taken](pose3(inner(message).position, inner(message).orientation))


def take_twist(message: Any) -> list[float]:
    """Velocity of an Odometry: forward, left, up [m/s] and turn rate [rad/s]."""
    twist = message.twist.twist
    return [*_xyz(twist.linear), float(twist.angular.z)]


def take_spread(message: Any) -> list[float]:
    """Largest standard deviation of the place of a PoseWithCovarianceStamped [m]; NaN if it is unknown."""
    covariance = np.asarray(message.pose.covariance, dtype=float).reshape(6, 6)[:2, :2]
    largest = float(np.linalg.eigvalsh(covariance)[-1]) if np.isfinite(covariance).all() else math.nan
    return [math.sqrt(largest) if largest >= 0.0 else math.nan]


def take_imu(taken: str) -> Take:
    """Value of an Imu."""
    if taken == "turn_rate":
        return lambda message: [float(message.angular_velocity.z)]
    if taken == "acceleration":
        return lambda message: _xyz(message.linear_acceleration)

    def take(message: Any) -> list[float]:
        if float(message.orientation_covariance[0]) == -1.0:  # by the message's definition
            raise DeviceError("the device does not estimate an orientation")
        return POSE_TAKES[taken](pose3(message.linear_acceleration, message.orientation))

    return take


def _xyz(vector: Any) -> list[float]:
    return [float(vector.x), float(vector.y), float(vector.z)]
