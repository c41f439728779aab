"""Where the robot should be over the next moments: along a path, along a timetable, or turning on the spot."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..compiled import compiled
from ..errors import InputError
from ..geometry import Pose2, Twist2, wrap_angle
from .drive import Array
from .grid import Grid
from .path import REACH, Path
from .profile import SpeedProfile

TURN_RATE = 1.5  # [rad/s] Gentle enough for sonars to keep up with.
TURN_ACCELERATION = 4.0  # [rad/s2]
SHARP = math.radians(100.0)  # A corner by more leads back: it is taken on the spot, for there is no driving round it.


class Preview(NamedTuple):
    """What a reference asks for, and how far the robot is from it.

    Attributes:
        stages: (k, 6) x [m], y [m], yaw [rad] in the world frame, without jumps and begun within pi of the robot's,
            then forward [m/s], left [m/s], turn [rad/s] in the body frame.
        cross_track: The robot's distance from the reference, left of it positive [m].
        heading_error: The robot's yaw minus the reference's, in (-pi, pi] [rad].
    """

    stages: Array
    cross_track: float
    heading_error: float


class Reference(ABC):
    """Something to follow."""

    @abstractmethod
    def sample(self, pose: Pose2, twist: Twist2, times: Array, lead: float) -> Preview:
        """Look ahead from where the robot is.

        Args:
            pose: The robot, in the world frame.
            twist: Its velocity, in its body frame.
            times: (k,) How far to look ahead of the moment of that pose, ascending [s].
            lead: How far ahead of now that moment is, when the follower has predicted the pose [s].
        """


class PathReference(Reference):
    """A path at the speeds of a profile, begun anew at each look from where the robot is.

    So a robot that was held up drives on from there instead of chasing a phantom. The stations are s0 + the integral
    of min(profile(s), v + a t). A robot whose heading is far off the path's turns on the spot first; so does one at a
    sharp corner, whose place is where the next leg begins.

    Args:
        path: Where.
        profile: How fast; made for the same path.
        turn_first: Heading error beyond which to turn on the spot [rad].
        turn_rate: Of that turn [rad/s].
        turn_acceleration: Of that turn [rad/s2].
        pivot: The drive's: how far ahead of its base the place lies about which it turns [m].

    Raises:
        InputError: The profile was made for another path.

    Attributes:
        s: The arc length of the robot's place on the path at the last look [m]; None before the first.
    """

    def __init__(
        self,
        path: Path,
        profile: SpeedProfile,
        *,
        turn_first: float = math.pi / 2.0,
        turn_rate: float = TURN_RATE,
        turn_acceleration: float = TURN_ACCELERATION,
        pivot: float = 0.0,
    ) -> None:
        self.path = path
        self.profile = profile
        self.s: float | None = None
        if len(profile.speeds) != len(path.samples):
            raise InputError("a path reference needs the speed profile of its own path, found that of another.")
        self._grid = Grid(np.column_stack([path.samples, profile.speeds**2]), path.spacing)
        self._corners = [corner + REACH for corner in _sharp_corners(path)]  # where the next leg begins
        self._turn_first = turn_first
        self._turn_rate = turn_rate
        self._turn_acceleration = turn_acceleration
        self._pivot = pivot

    @property
    def remaining(self) -> float:
        """Arc length to the end [m]."""
        return self.path.length - (self.s or 0.0)

    def sample(self, pose: Pose2, twist: Twist2, times: Array, lead: float) -> Preview:
        s = self.s = self._place(pose)
        x, y, tangent, _, squared = self._grid.look(s)
        yaw = tangent if self.path.length > 0.0 else pose.yaw  # a single place asks for no heading
        error = wrap_angle(pose.yaw - yaw)
        c, s_yaw = math.cos(yaw), math.sin(yaw)
        cross = c * (pose.y - y) - s_yaw * (pose.x - x)
        if abs(error) > self._turn_first:
            turning = _turn(pose.yaw, -error, twist.turn, self._turn_rate, self._turn_acceleration, times)
            return Preview(_standing(pose, *turning, self._pivot), cross, error)
        along = max(0.0, twist.forward * math.cos(error) - twist.left * math.sin(error))
        there = self._grid.at(self.profile.ahead(s, along, math.sqrt(squared), times))
        stages = np.empty((len(times), 6))
        path_stages(there, (pose.yaw - error - tangent, along, self.profile.acceleration), times, stages)
        return Preview(stages, cross, error)

    def _place(self, pose: Pose2) -> float:
        """The arc length of the robot's place on the path [m]; never again before a sharp corner that it was at."""
        passed = max((leg for leg in self._corners if leg <= (self.s or 0.0)), default=0.0)
        s = self.path.project(pose.x, pose.y, self.s, least=passed)
        return next((leg for leg in self._corners if leg - 2.0 * REACH <= s < leg), s)


@compiled
def path_stages(rows: Array, given: tuple[float, float, float], times: Array, stages: Array) -> None:
    """Find the stages (k, 6) at some times (k,) [s], of rows of a path.

    Args:
        rows: (k, 5) x [m], y [m], heading [rad], curvature [1/m], and the square of the speed limit [m2/s2].
        given: What to add to the heading [rad], and how fast it goes [m/s] and may gain speed [m/s2].
        times: (k,) For when.
        stages: (k, 6) As in `Preview`.
    """
    turn, speed, acceleration = given
    speeds = np.minimum(np.sqrt(rows[:, 4]), speed + acceleration * times)
    stages[:, :2], stages[:, 2], stages[:, 3], stages[:, 4] = rows[:, :2], rows[:, 2] + turn, speeds, 0.0
    stages[:, 5] = speeds * rows[:, 3]


class TimedReference(Reference):
    """Poses at given times, such as a planned trajectory or a leader's predicted way.

    Before the first time the first pose is held, after the last the last.

    Args:
        times: (m,) Strictly ascending, on the clock of `now` [s].
        poses: (m, 3) x [m], y [m], yaw [rad] in the world frame.
        now: Tells the present time, such as `clock.now` [s].

    Raises:
        InputError: The arrays do not fit, are not finite, or the times do not ascend.
    """

    def __init__(self, times: npt.ArrayLike, poses: npt.ArrayLike, now: Callable[[], float]) -> None:
        self._times, self._poses = np.array(times, dtype=float), np.array(poses, dtype=float, order="C")
        if self._times.ndim != 1 or self._poses.shape != (len(self._times), 3) or len(self._times) == 0:
            raise InputError(
                f"a timed reference needs times (m,) and poses (m, 3), found shapes {self._times.shape} and "
                f"{self._poses.shape}."
            )
        # A row of rest on either side, found by the same search as the velocities between.
        rows = len(self._times) + 1
        self._since, self._from, self._velocity = np.empty(rows), np.empty((rows, 3)), np.empty((rows, 3))
        lines = self._times, self._poses, self._since, self._from, self._velocity
        if (fit := timed_lines(*lines)) is None:
            self._poses[:, 2] = np.unwrap(self._poses[:, 2])
            fit = timed_lines(*lines) is not False
        if not fit:
            raise InputError("a timed reference needs finite poses at finite times that ascend.")
        self._now = now

    def sample(self, pose: Pose2, twist: Twist2, times: Array, lead: float) -> Preview:
        start = self._now() + lead
        at = np.empty(len(times) + 1)
        at[0], at[1:] = start, start + times
        stages = np.empty((len(at), 6))
        timed_stages(self._times, self._since, self._from, self._velocity, at, stages)
        x, y, yaw = stages[0, :3].tolist()
        error = wrap_angle(pose.yaw - yaw)
        cross = math.cos(yaw) * (pose.y - y) - math.sin(yaw) * (pose.x - x)
        stages[:, 2] += pose.yaw - error - yaw
        return Preview(stages[1:], cross, error)


@compiled
def timed_lines(times: Array, poses: Array, since: Array, begin: Array, velocity: Array) -> bool | None:
    """Find the lines between poses, and a row of rest before and after them.

    Args:
        times: (m,) Of the poses [s].
        poses: (m, 3) x [m], y [m], yaw [rad].
        since: (m + 1,) When each line begins.
        begin: (m + 1, 3) Where.
        velocity: (m + 1, 3) On it, in the world frame.

    Returns:
        Whether all is finite and the times ascend; None where the yaw jumps by half a turn or more, too.
    """
    steps, ends = times[1:] - times[:-1], (float(times[0]), float(times[-1]))
    if not (all(map(math.isfinite, ends)) and (steps > 0.0).all() and np.isfinite(poses).all()):
        return False
    moved = poses[1:] - poses[:-1]
    since[0], since[1:], begin[0], begin[1:] = times[0], times, poses[0], poses
    velocity[:] = 0.0
    velocity[1:-1] = moved / steps[:, None]
    return None if (np.abs(moved[:, 2]) >= math.pi).any() else True


@compiled
def timed_stages(times: Array, since: Array, begin: Array, velocity: Array, at: Array, stages: Array) -> None:
    """Find the stages (k, 6) at some times (k,) [s], of poses at ascending times (m,) [s] with lines in between.

    Args:
        times: (m,) Of the poses.
        since: (m + 1,) When each line begins.
        begin: (m + 1, 3) Where.
        velocity: (m + 1, 3) On it, in the world frame.
        at: (k,) For when.
        stages: (k, 6) As in `Preview`.
    """
    row = times.searchsorted(at, "right")  # as np.interp does it, to the bit, for all three at once
    passed = (at - since.take(row))[:, None]
    stages[:, :3] = velocity.take(row, axis=0) * passed + begin.take(row, axis=0)
    there = velocity.take(times.searchsorted(at), axis=0)
    c, s = np.cos(stages[:, 2]), np.sin(stages[:, 2])
    stages[:, 3] = c * there[:, 0] + s * there[:, 1]
    stages[:, 4] = c * there[:, 1] - s * there[:, 0]
    stages[:, 5] = there[:, 2]


class TurnReference(Reference):
    """A turn on the spot to a yaw, the short way round.

    Args:
        yaw: Where to look in the end, in the world frame [rad].
        x: The spot [m].
        y: The spot [m].
        rate: Fastest turn [rad/s].
        acceleration: [rad/s2].
        pivot: The drive's: how far ahead of its base the place lies about which it turns [m].
    """

    def __init__(
        self,
        yaw: float,
        x: float,
        y: float,
        rate: float = TURN_RATE,
        acceleration: float = TURN_ACCELERATION,
        pivot: float = 0.0,
    ) -> None:
        self.yaw = yaw
        self.x = x
        self.y = y
        self._rate = rate
        self._acceleration = acceleration
        self._pivot = pivot

    def sample(self, pose: Pose2, twist: Twist2, times: Array, lead: float) -> Preview:
        error = wrap_angle(pose.yaw - self.yaw)
        cross = math.cos(self.yaw) * (pose.y - self.y) - math.sin(self.yaw) * (pose.x - self.x)
        turning = _turn(pose.yaw, -error, twist.turn, self._rate, self._acceleration, times)
        return Preview(_standing(Pose2(self.x, self.y, pose.yaw), *turning, self._pivot), cross, error)


def _sharp_corners(path: Path) -> list[float]:
    """Arc lengths at which a path bends by more than SHARP within REACH each way [m]."""
    if path.length <= 2.0 * REACH:
        return []
    cells, heading = round(REACH / path.spacing), path.samples[:, 2]
    sharp = np.flatnonzero(np.abs(heading[2 * cells :] - heading[: -2 * cells]) > SHARP) + cells
    runs = np.split(sharp, np.flatnonzero(np.diff(sharp) > 1) + 1)
    return [path.spacing * float(run.mean()) for run in runs if len(run)]


def _turn(yaw: float, error: float, turn: float, rate: float, acceleration: float, times: Array) -> tuple[Array, Array]:
    """Yaws [rad] and turn rates [rad/s] of a trapezoidal turn by `error` from `yaw`, now turning at `turn`."""
    if error * turn < 0.0 and abs(error) > math.pi - 0.3:
        error -= math.copysign(math.tau, error)  # half-way round already: go on rather than back
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


def _standing(pose: Pose2, yaws: Array, rates: Array, pivot: float) -> Array:
    """(k, 6) Stages of a turn on the spot from a pose, about a place that is so far ahead of the base [m]."""
    stages = np.zeros((len(yaws), 6))
    stages[:, 0], stages[:, 1], stages[:, 2], stages[:, 5] = pose.x, pose.y, yaws, rates
    if pivot != 0.0:
        stages[:, 0] += pivot * (math.cos(pose.yaw) - np.cos(yaws))
        stages[:, 1] += pivot * (math.sin(pose.yaw) - np.sin(yaws))
        stages[:, 4] = -pivot * rates
    return stages
