"""PathDrive: path following with the trajectory follower, as the motion actions use it."""

from __future__ import annotations

import math

import numpy as np

from ..action import Action, Body
from ..control.locomotion import Array
from ..control.path import Path
from ..control.profile import speed_profile
from ..control.reference import PathReference, Reference
from ..event import FollowerStepped
from ..geometry import Pose2, Twist2, wrap_angle
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
        turn_first: Heading error beyond which the robot turns on the spot [rad].
    """

    def __init__(
        self,
        body: Body,
        cruise: float,
        lateral_acceleration: float = 1.0,
        turn_first: float = TURN_FIRST,
    ) -> None:
        self._body = body
        self._cruise = cruise
        self._lateral_acceleration = lateral_acceleration
        self._turn_first = turn_first
        self._watch = PoseWatch()
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
        """Heading of the path at the robot's arc length, relative to the robot's heading [rad]; 0 without a path."""
        reference, pose = self._reference, self._body.knowledge.robot.pose()
        return 0.0 if reference is None else wrap_angle(float(reference.path.heading(reference.s or 0.0)) - pose.yaw)

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

    def limit(self, limit: Array, end_speed: float = 0.0) -> None:
        """Replace the speed limits of the present path, if there is one; arguments as in `begin`."""
        if self._reference is not None:
            s = self._reference.s
            self._reference = self._along(self._reference.path, limit, end_speed)
            self._reference.s = s

    def _along(self, path: Path, limit: Array | None, end_speed: float) -> PathReference:
        profile = speed_profile(
            path,
            self._body.locomotion,
            cruise=self._cruise,
            lateral_acceleration=self._lateral_acceleration,
            end_speed=end_speed,
            limit=limit,
        )
        return PathReference(
            path, profile, turn_first=self._turn_first, icr_offset=self._follower.locomotion.icr_offset
        )

    def pose(self) -> Pose2 | None:
        """Pose of the robot, world frame; None while it is unknown. While it is None, the action must `brake`.

        Raises:
            ActionFailed: LOST_POSE, if the pose stays unknown.
        """
        return self._watch.read(self._body)

    def stationary(self) -> bool:
        """Whether the robot is stationary; true if its motion is not measured."""
        return not any(abs(speed) > STANDING for speed in self._body.knowledge.robot.motion().tolist())

    def step(self, pose: Pose2) -> Action:
        """Return the action that drives along the path in this period; it brakes if there is no path."""
        if self._reference is None:
            return self.brake()
        return self.follow(pose, self._reference)

    def follow(self, pose: Pose2, reference: Reference) -> Action:
        """Compute the motion of this period with the follower, and return the action that commands it."""
        body = self._body
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
        return hold(body, values.tolist(), body.period)

    def brake(self) -> Action:
        """Return the action that commands the body not to move in this period."""
        self._owns_motion = False
        return hold(self._body, self._body.locomotion.rest, self._body.period)

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
