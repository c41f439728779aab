"""PathDrive: path following with the trajectory follower, as the motion actions use it."""

from __future__ import annotations

import math

import numpy as np

from ..base.geometry import Pose2, Twist2, wrap_angle
from ..control.axis import AxisLimits
from ..control.heading import blended_yaws, limited_yaws
from ..control.locomotion import Array
from ..control.path import Path
from ..control.profile import speed_profile
from ..control.reference import TURN_ACCELERATION, TURN_RATE, PathReference, Reference
from ..event import FollowerStepped, PathPlanned
from ..interfaces.action import Action, Body
from .altitude import Altitude
from .heading import ALONG, Heading
from .pose import PoseWatch
from .set_twist import hold

TURN_FIRST = math.radians(60.0)
"""Heading error beyond which the robot turns on the spot before it follows a path [rad]."""

STANDING = 0.05
"""Wheel linear speed, or speed of an axis, below which the robot counts as stationary [m/s, rad/s]."""

OFF = 0.3
"""Distance from the path beyond which a new path from the robot's position is planned [m]."""


class PathDrive:
    """Converter from paths to motion actions (`hold`), one per control period, for one motion action.

    The constructor resets the follower, which then starts from the measured motion.

    Args:
        body: Robot.
        cruise: Speed on straight parts [m/s].
        lateral_acceleration: Maximum lateral acceleration in curves [m/s2].
        turn_first: Heading error beyond which the robot turns on the spot, with the heading `along` [rad].
        heading: Yaw on the path; None for `along`.
        height: Height to fly at [m]; +inf for no change.
    """

    def __init__(
        self,
        body: Body,
        cruise: float,
        lateral_acceleration: float = 1.0,
        turn_first: float = TURN_FIRST,
        heading: Heading | None = None,
        height: float = math.inf,
    ) -> None:
        self._body = body
        self._cruise = cruise
        self._lateral_acceleration = lateral_acceleration
        self._turn_first = turn_first
        self._heading = heading or Heading(ALONG)
        self._turning = AxisLimits(
            min(TURN_RATE, body.locomotion.turn_limit),
            min(TURN_ACCELERATION, 0.5 * body.locomotion.turn_acceleration_limit),
        )
        self._altitude = None if math.isinf(height) else Altitude(body, height)
        self._watch = PoseWatch()
        self._pose = Pose2(math.nan, math.nan, math.nan)
        self._limit: tuple[Array | None, float] = (None, 0.0)
        self._reference: PathReference | None = None
        self._cross_track = 0.0
        self._owns_motion = False
        self._backward = False
        self._follower = body.follower
        self._follower.reset()

    @property
    def backward(self) -> bool:
        """Whether the robot drives backward along its path; change it only near standstill."""
        return self._backward

    @backward.setter
    def backward(self, backward: bool) -> None:
        if backward is not self._backward:
            self._backward, self._owns_motion = backward, False
            self._follower = self._body.follower.backward if backward else self._body.follower
            self._follower.reset()

    @property
    def heading_error(self) -> float:
        """Heading of the path at the robot's arc length, relative to the robot's heading [rad].

        It is 0 without a path, and with a heading other than `along`.
        """
        reference, pose = self._reference, self._body.knowledge.robot.pose()
        if reference is None or not self._heading.along:
            return 0.0
        return wrap_angle(float(reference.path.heading(reference.s or 0.0)) - pose.yaw)

    @property
    def remaining(self) -> float:
        """Arc length to the end of the path [m]; +inf without a path."""
        return math.inf if self._reference is None else self._reference.remaining

    @property
    def lost(self) -> bool:
        """Whether the action needs a new path: there is none, or the robot is farther than `OFF` from it."""
        return self._reference is None or abs(self._cross_track) > OFF

    def begin(self, path: Path, limit: Array | None = None, end_speed: float = 0.0) -> None:
        """Follow a new path.

        Args:
            path: Path from the robot's position.
            limit: Speed limits at the samples of the path, in addition to those for cruise speed and curves, shape (n,)
                [m/s].
            end_speed: Speed limit at the end of the path [m/s].
        """
        self._reference = self._along(path, limit, end_speed)
        self._reference.s = 0.0  # otherwise a path that ends at its start would count as driven
        self._cross_track = 0.0
        self._body.note(PathPlanned, points=tuple(path.outline()))

    def limit(self, limit: Array | None, end_speed: float = 0.0) -> None:
        """Replace the speed limits of the present path, if there is one; arguments as in `begin`."""
        if self._reference is not None:
            s = self._reference.s
            self._reference = self._along(self._reference.path, limit, end_speed)
            self._reference.s = s

    def yaws(self, path: Path) -> Array | None:
        """Planned yaws at the samples of a path, shape (n,) [rad]; None with the heading `along`.

        The yaws begin with the robot's present one, at its arc length on the present path or at the start of another.

        Raises:
            ActionFailed: NO_GOAL, if the position of the place to look at is not known.
        """
        if self._heading.along:
            return None
        reference = self._reference
        s = 0.0 if reference is None or reference.path is not path else reference.s or 0.0
        wanted = self._heading.yaws(self._body, path.samples[:, :2], self._pose)
        return blended_yaws(wanted, path.spacing, s, self._pose.yaw, self._turning.max_speed / self._cruise)

    def turned(self, path: Array, times: Array) -> Array:
        """Copy of a timed path (k, 3) from the robot on, at times (k,) [s] from 0 on, with the yaws of the heading."""
        wanted = self._heading.yaws(self._body, path[:, :2], self._pose)
        turn = self._body.knowledge.robot.turn_rate()
        turned = path.copy()
        turned[0, 2] = self._pose.yaw
        turned[1:, 2], _ = limited_yaws(
            wanted, times[1:], self._pose.yaw, turn if math.isfinite(turn) else 0.0, self._turning
        )
        return turned

    def at_height(self, tolerance: float) -> bool:
        """Whether the height differs from the desired one by at most the tolerance [m]; true if none is desired."""
        return abs(self.height_error()) <= tolerance

    def faces(self, pose: Pose2) -> bool:
        """Whether a pose has the yaw of arrival, if the heading is an angle."""
        return self._heading.faces(pose)

    def height_error(self) -> float:
        """Desired height minus the present one [m]; 0 if none is desired, NaN while the height is unknown."""
        return 0.0 if self._altitude is None else self._altitude.error()

    def _along(self, path: Path, limit: Array | None, end_speed: float) -> PathReference:
        self._limit = limit, end_speed
        yaws = self.yaws(path)
        profile = speed_profile(
            path,
            self._body.locomotion,
            cruise=self._cruise,
            lateral_acceleration=self._lateral_acceleration,
            end_speed=end_speed,
            limit=limit,
            yaws=yaws,
            turn_rate=self._turning.max_speed,
        )
        if yaws is not None:
            turning = self._turning
            return PathReference(
                path, profile, turn_rate=turning.max_speed, turn_acceleration=turning.max_acceleration, yaws=yaws
            )
        return PathReference(
            path, profile, turn_first=self._turn_first, icr_offset=self._follower.locomotion.icr_offset
        )

    def pose(self) -> Pose2 | None:
        """Pose of the robot, world frame; None while it is unknown. While it is None, the action must `brake`.

        Raises:
            ActionFailed: LOST_POSE, if the pose stays unknown.
        """
        pose = self._watch.read(self._body)
        if pose is not None:
            self._pose = pose
        return pose

    def stationary(self) -> bool:
        """Whether the robot is stationary; true if its motion is not measured.

        A robot that looks at a place may still turn, because the place may move. A robot without wheels and with
        another heading than `along` is not stationary while a signal of its planar motion is invalid.
        """
        motion, locomotion = self._body.knowledge.robot.motion(), self._body.locomotion
        looks = bool(self._heading.place)
        if not (self._heading.along or locomotion.wheels) and self._unknown(locomotion.twist(motion), turn=not looks):
            return False
        if looks:
            twist = locomotion.twist(motion)
            return not math.hypot(twist.forward, twist.left) > STANDING
        return not any(abs(speed) > STANDING for speed in motion.tolist())

    def step(self, pose: Pose2) -> Action:
        """Return the action that drives along the path in this period; it brakes if there is no path."""
        if self._reference is None:
            return self.brake()
        if self._heading.changed(self._body):
            self.limit(*self._limit)
        return self.follow(pose, self._reference)

    def follow(self, pose: Pose2, reference: Reference) -> Action:
        """Compute the motion of this period with the follower, and return the action that commands it."""
        body = self._body
        if self._altitude is not None and self._altitude.climbs_first():
            return self.brake()
        if self._backward:  # the follower plans for a robot turned by 180 deg
            pose = Pose2(pose.x, pose.y, wrap_angle(pose.yaw + math.pi))
        measured = None if self._owns_motion else self._measured()
        command = self._follower.step(pose, measured, reference, body.period)
        if math.isfinite(command.cross_track):
            self._cross_track = command.cross_track
            body.note(
                FollowerStepped,
                cross_track=command.cross_track,
                heading_error=command.heading_error,
                rung=command.rung,
                solve_time=command.solve_time if math.isfinite(command.solve_time) else 0.0,
            )
        values = self._turned(command.values) if self._backward else command.values
        if self._altitude is not None:
            values = self._altitude.added(values)
        return hold(body, values.tolist(), body.period)

    def start(self, pose: Pose2) -> tuple[Pose2, Twist2, float]:
        """Pose and velocity of the robot when the next command takes effect, and the time until then [s]."""
        if not self._owns_motion and (measured := self._measured()) is not None:
            return pose, self._body.locomotion.twist(measured), 0.0
        return self._follower.start(pose)

    def brake(self) -> Action:
        """Return the action that commands the body not to move in the plane in this period."""
        self._owns_motion = False
        rest = self._body.locomotion.rest
        if self._altitude is not None:
            rest = self._altitude.added(np.array(rest)).tolist()
        return hold(self._body, rest, self._body.period)

    def _unknown(self, twist: Twist2, *, turn: bool) -> bool:
        """Whether a signal of the motion in the plane is invalid; the turn rate counts on request."""
        speeds = {"speed": twist.forward, "lateral_speed": twist.left, **({"turn_rate": twist.turn} if turn else {})}
        signals = self._body.knowledge.signals
        return any(math.isnan(speed) and name in signals for name, speed in speeds.items())

    def _turned(self, values: Array) -> Array:
        """Convert values (m,) of a motion between the robot and a robot turned by 180 deg, in either direction."""
        twist = self._body.locomotion.twist(values)
        return self._body.locomotion.command(Twist2(-twist.forward, twist.turn, -twist.left))

    def _measured(self) -> Array | None:
        """Measured motion (m,) for the follower to start from; None while unknown."""
        self._owns_motion = True
        values = self._body.knowledge.robot.motion()
        if not np.isfinite(values).all():
            return None
        return self._turned(values) if self._backward else values
