"""References for the trajectory follower: a path with a speed profile, timed poses, or a turn on the spot."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..base.errors import InputError
from ..base.geometry import Pose2, Twist2, wrap_angle
from .axis import AxisLimits
from .heading import limited_yaws
from .locomotion import Array
from .path import REACH, Grid, Path
from .profile import SpeedProfile

TURN_RATE = 1.5  # [rad/s] slow enough for sonars
TURN_ACCELERATION = 4.0  # [rad/s2]
SHARP = math.radians(100.0)  # at a sharper corner the robot turns on the spot


class Preview(NamedTuple):
    """Future poses and twists of a reference, and the present tracking errors.

    Attributes:
        stages: x [m], y [m] and yaw [rad], world frame, and forward [m/s], left [m/s] and turn [rad/s], body frame,
            shape (k, 6). The yaw is continuous and starts within pi of the robot's.
        cross_track: Distance of the robot from the reference, left of it positive [m].
        heading_error: Yaw of the robot minus that of the reference, in (-pi, pi] [rad].
    """

    stages: Array
    cross_track: float
    heading_error: float


class Reference(ABC):
    """Reference trajectory of the follower."""

    @abstractmethod
    def sample(self, pose: Pose2, twist: Twist2, times: Array, lead: float) -> Preview:
        """Sample the reference ahead of the robot.

        Args:
            pose: Pose of the robot, world frame, predicted by the follower.
            twist: Velocity of the robot, body frame.
            times: Times of the stages, relative to the time of `pose`, ascending, shape (k,) [s].
            lead: Time of `pose`, relative to the present time [s].
        """


class PathReference(Reference):
    """Path with a speed profile, sampled from the robot's present arc length on.

    A delayed robot therefore continues from its position instead of chasing a moving target. The arc length at time t
    is s0 plus the integral of min(profile(s), v + a t). A robot with a large heading error turns on the spot first. A
    robot at a sharp corner also turns on the spot, then continues from the beginning of the next leg.

    Args:
        path: Path to follow.
        profile: Speed profile of this path.
        turn_first: Heading error beyond which the robot turns on the spot [rad].
        turn_rate: Maximum turn rate on the spot [rad/s].
        turn_acceleration: Angular acceleration on the spot [rad/s2].
        icr_offset: Distance of the centre of rotation ahead of its base, see `Locomotion.icr_offset` [m].
        yaws: Yaw at each sample of the path, without jumps of 2 pi, shape (n,) [rad]; None for the tangent. A robot
            with yaws turns while it drives, and never on the spot.

    Raises:
        InputError: The profile was made for another path, or the yaws were.

    Attributes:
        s: Arc length of the robot at the last sample [m]; None before the first.
    """

    def __init__(
        self,
        path: Path,
        profile: SpeedProfile,
        *,
        turn_first: float = math.pi / 2.0,
        turn_rate: float = TURN_RATE,
        turn_acceleration: float = TURN_ACCELERATION,
        icr_offset: float = 0.0,
        yaws: Array | None = None,
    ) -> None:
        self.path = path
        self.profile = profile
        self.s: float | None = None
        if len(profile.speeds) != len(path.samples):
            raise InputError(
                f"a path reference needs the speed profile of its own path with {len(path.samples)} samples, found one "
                f"with {len(profile.speeds)}."
            )
        if yaws is not None and len(yaws) != len(path.samples):
            raise InputError(
                f"a path reference needs a yaw at each of the {len(path.samples)} samples, found {len(yaws)}."
            )
        self._grid = Grid(np.column_stack([path.samples, profile.speeds**2]), path.spacing)
        self._yaws = None if yaws is None else Grid(yaws[:, None], path.spacing)
        self._corners = [corner + REACH for corner in _sharp_corners(path)]  # arc lengths at which the next legs begin
        self._turn_first = turn_first
        self._turn_rate = turn_rate
        self._turn_acceleration = turn_acceleration
        self._icr_offset = icr_offset
        self._axis = AxisLimits(turn_rate, turn_acceleration)

    @property
    def remaining(self) -> float:
        """Arc length from the robot to the end of the path [m]."""
        return self.path.length - (self.s or 0.0)

    def sample(self, pose: Pose2, twist: Twist2, times: Array, lead: float) -> Preview:
        s = self.s = self._project(pose)
        if self._yaws is not None:
            return self._sample_with_yaws(self._yaws, s, pose, twist, times)
        x, y, tangent, _, squared = self._grid.row(s)
        yaw = tangent if self.path.length > 0.0 else pose.yaw  # a path of one point has no heading
        error = wrap_angle(pose.yaw - yaw)
        c, s_yaw = math.cos(yaw), math.sin(yaw)
        cross = c * (pose.y - y) - s_yaw * (pose.x - x)
        if abs(error) > self._turn_first:
            turning = _turn(pose.yaw, -error, twist.turn, self._turn_rate, self._turn_acceleration, times)
            return Preview(_turn_stages(pose, *turning, self._icr_offset), cross, error)
        along = max(0.0, twist.forward * math.cos(error) - twist.left * math.sin(error))
        there = self._grid.at(self.profile.ahead(s, along, math.sqrt(squared), times))
        speeds = np.minimum(np.sqrt(there[:, 4]), along + self.profile.acceleration * times)
        stages = np.zeros((len(times), 6))
        stages[:, :3] = there[:, :3]
        stages[:, 2] += pose.yaw - error - tangent
        stages[:, 3] = speeds
        stages[:, 5] = speeds * there[:, 3]
        return Preview(stages, cross, error)

    def _sample_with_yaws(self, yaws: Grid, s: float, pose: Pose2, twist: Twist2, times: Array) -> Preview:
        """Preview from the arc length s [m] on, with yaws that approach those of the grid from the robot's yaw."""
        x, y, tangent, _, squared = self._grid.row(s)
        c, s_tangent = math.cos(tangent), math.sin(tangent)
        off = pose.yaw - tangent
        along = max(0.0, twist.forward * math.cos(off) - twist.left * math.sin(off))
        stations = self.profile.ahead(s, along, math.sqrt(squared), times)
        there, wanted = self._grid.at(stations), yaws.at(np.concatenate([[s], stations]))[:, 0]
        speeds = np.minimum(np.sqrt(there[:, 4]), along + self.profile.acceleration * times)
        stages = np.empty((len(times), 6))
        stages[:, :2] = there[:, :2]
        stages[:, 2], stages[:, 5] = limited_yaws(wanted, times, pose.yaw, twist.turn, self._axis)
        ahead = there[:, 2] - stages[:, 2]
        stages[:, 3], stages[:, 4] = speeds * np.cos(ahead), speeds * np.sin(ahead)
        cross = c * (pose.y - y) - s_tangent * (pose.x - x)
        return Preview(stages, cross, wrap_angle(pose.yaw - float(wanted[0])))

    def _project(self, pose: Pose2) -> float:
        """Arc length of the robot on the path [m]; never before a sharp corner that the robot has reached."""
        if not self._corners:
            return self.path.project(pose.x, pose.y, self.s)
        passed = max((leg for leg in self._corners if leg <= (self.s or 0.0)), default=0.0)
        s = self.path.project(pose.x, pose.y, self.s, least=passed)
        return next((leg for leg in self._corners if leg - 2.0 * REACH <= s < leg), s)


class TimedReference(Reference):
    """Poses at given times, such as a planned trajectory or the predicted path of a leader.

    The first pose holds before the first time, the last pose after the last time.

    Args:
        times: Times on the clock of `now`, strictly ascending, shape (m,) [s].
        poses: x [m], y [m], yaw [rad], world frame, shape (m, 3).
        now: Function that returns the present time, such as `clock.now` [s].

    Raises:
        InputError: The shapes do not fit, a value is not finite, or the times do not ascend.
    """

    def __init__(self, times: npt.ArrayLike, poses: npt.ArrayLike, now: Callable[[], float]) -> None:
        self._times, self._poses = np.array(times, dtype=float), np.array(poses, dtype=float, order="C")
        if self._times.ndim != 1 or self._poses.shape != (len(self._times), 3) or len(self._times) == 0:
            raise InputError(
                f"a timed reference needs times (m,) and poses (m, 3), found shapes {self._times.shape} and "
                f"{self._poses.shape}."
            )
        finite = np.isfinite(self._times).all() and np.isfinite(self._poses).all()
        if not (finite and ((steps := np.diff(self._times)) > 0.0).all()):
            raise InputError("a timed reference needs finite poses at finite times that ascend.")
        moved = np.diff(self._poses, axis=0)
        if (np.abs(moved[:, 2]) >= math.pi).any():
            self._poses[:, 2] = np.unwrap(self._poses[:, 2])
            moved = np.diff(self._poses, axis=0)
        # A row of zero velocity at each end, so that the same search covers times outside.
        self._since = np.concatenate([self._times[:1], self._times])
        self._from = np.concatenate([self._poses[:1], self._poses])
        self._velocity = np.zeros((len(self._from), 3))
        self._velocity[1:-1] = moved / steps[:, None]
        self._now = now

    def sample(self, pose: Pose2, twist: Twist2, times: Array, lead: float) -> Preview:
        start = self._now() + lead
        at = np.empty(len(times) + 1)
        at[0], at[1:] = start, start + times
        row = self._times.searchsorted(at, "right")  # bit-identical to np.interp, for all three columns at once
        stages = np.empty((len(at), 6))
        passed = (at - self._since.take(row))[:, None]
        stages[:, :3] = self._velocity.take(row, axis=0) * passed + self._from.take(row, axis=0)
        there = self._velocity.take(self._times.searchsorted(at), axis=0)
        c, s = np.cos(stages[:, 2]), np.sin(stages[:, 2])
        stages[:, 3] = c * there[:, 0] + s * there[:, 1]
        stages[:, 4] = c * there[:, 1] - s * there[:, 0]
        stages[:, 5] = there[:, 2]
        x, y, yaw = stages[0, :3].tolist()
        error = wrap_angle(pose.yaw - yaw)
        cross = math.cos(yaw) * (pose.y - y) - math.sin(yaw) * (pose.x - x)
        stages[:, 2] += pose.yaw - error - yaw
        return Preview(stages[1:], cross, error)


class TurnReference(Reference):
    """Turn on the spot to a yaw, in the shorter direction.

    Args:
        yaw: Final yaw, world frame [rad].
        x: Position of the turn, world frame [m].
        y: Position of the turn, world frame [m].
        icr_offset: Distance of the centre of rotation ahead of its base, see `Locomotion.icr_offset` [m].
    """

    def __init__(self, yaw: float, x: float, y: float, icr_offset: float = 0.0) -> None:
        self.yaw = yaw
        self.x = x
        self.y = y
        self._icr_offset = icr_offset

    def sample(self, pose: Pose2, twist: Twist2, times: Array, lead: float) -> Preview:
        error = wrap_angle(pose.yaw - self.yaw)
        cross = math.cos(self.yaw) * (pose.y - self.y) - math.sin(self.yaw) * (pose.x - self.x)
        turning = _turn(pose.yaw, -error, twist.turn, TURN_RATE, TURN_ACCELERATION, times)
        return Preview(_turn_stages(Pose2(self.x, self.y, pose.yaw), *turning, self._icr_offset), cross, error)


def _sharp_corners(path: Path) -> list[float]:
    """Arc lengths of sharp corners [m]: the heading changes by more than SHARP from REACH before to REACH after."""
    if path.length <= 2.0 * REACH:
        return []
    cells, heading = round(REACH / path.spacing), path.samples[:, 2]
    sharp = np.flatnonzero(np.abs(heading[2 * cells :] - heading[: -2 * cells]) > SHARP) + cells
    runs = np.split(sharp, np.flatnonzero(np.diff(sharp) > 1) + 1)
    return [path.spacing * float(run.mean()) for run in runs if len(run)]


def _turn(yaw: float, error: float, turn: float, rate: float, acceleration: float, times: Array) -> tuple[Array, Array]:
    """Yaws [rad] and turn rates [rad/s] of a turn with trapezoidal rate profile.

    Args:
        yaw: Present yaw [rad].
        error: Angle to turn, left positive [rad].
        turn: Present turn rate [rad/s].
        rate: Maximum turn rate [rad/s].
        acceleration: Angular acceleration [rad/s2].
        times: Times from now on, shape (k,) [s].
    """
    if error * turn < 0.0 and abs(error) > math.pi - 0.3:
        error -= math.copysign(math.tau, error)  # already near the half turn: continue instead of reversing
    sign = math.copysign(1.0, error)
    angle, w0 = abs(error), max(0.0, sign * turn)
    peak = max(w0, min(rate, math.sqrt(acceleration * angle + 0.5 * w0 * w0)), 1e-9)
    rise, fall = (peak - w0) / acceleration, peak / acceleration
    hold = max(0.0, angle - 0.5 * (w0 + peak) * rise - 0.5 * peak * fall) / peak
    t1 = np.clip(times, 0.0, rise)
    t2 = np.clip(times - rise, 0.0, hold)
    t3 = np.clip(times - (rise + hold), 0.0, fall)
    turned = (w0 + 0.5 * acceleration * t1) * t1 + peak * t2 + (peak - 0.5 * acceleration * t3) * t3
    rates = w0 + acceleration * t1 - acceleration * t3
    return yaw + sign * np.minimum(turned, angle), sign * np.maximum(rates, 0.0)


def _turn_stages(pose: Pose2, yaws: Array, rates: Array, icr_offset: float) -> Array:
    """Stages of a turn on the spot, as in `Preview.stages`, shape (k, 6).

    Args:
        pose: Present pose of the base, world frame.
        yaws: Yaws, shape (k,) [rad].
        rates: Turn rates, shape (k,) [rad/s].
        icr_offset: Distance from the base forward to the point about which the robot turns [m].
    """
    stages = np.zeros((len(yaws), 6))
    stages[:, 0], stages[:, 1], stages[:, 2], stages[:, 5] = pose.x, pose.y, yaws, rates
    if icr_offset != 0.0:
        stages[:, 0] += icr_offset * (math.cos(pose.yaw) - np.cos(yaws))
        stages[:, 1] += icr_offset * (math.sin(pose.yaw) - np.sin(yaws))
        stages[:, 4] = -icr_offset * rates
    return stages
