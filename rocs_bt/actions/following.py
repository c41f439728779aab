"""Driving along a path with the follower: what GoTo and FollowPath share."""

from __future__ import annotations

import math

import numpy as np

from ..action import Action, Body
from ..control.drive import Array
from ..control.path import Path
from ..control.profile import speed_profile
from ..control.reference import PathReference, Reference
from ..event import Followed
from ..geometry import Pose2
from .pose import PoseWatch
from .set_wheel_speed import SetWheelSpeed

TURN_FIRST = math.radians(60.0)
"""Heading error beyond which the robot turns on the spot before it follows a path [rad]."""

STANDING = 0.05
"""Rim speed below which the robot counts as arrived and not as passing [m/s]."""

OFF = 0.3
"""Distance from the path beyond which a new one is planned from where the robot is [m]."""


class PathDrive:
    """One action's drive along paths, as a stream of SetWheelSpeed actions, one a period.

    It takes the follower over from whoever had it, and tells it how fast the wheels turn at that moment.

    Args:
        body: The robot.
        cruise: The speed wanted on a straight [m/s].
    """

    def __init__(self, body: Body, cruise: float) -> None:
        self._body = body
        self._cruise = cruise
        self._watch = PoseWatch()
        self._reference: PathReference | None = None
        self._cross_track = 0.0
        self._owns_wheels = False
        body.follower.reset()

    @property
    def remaining(self) -> float:
        """Arc length to the path's end [m]; +inf without a path."""
        return math.inf if self._reference is None else self._reference.remaining

    @property
    def lost(self) -> bool:
        """Whether there is no path, or the robot is too far off it."""
        return self._reference is None or abs(self._cross_track) > OFF

    def begin(self, path: Path) -> None:
        """Follow this path, which begins where the robot is, from now on."""
        profile = speed_profile(path, self._body.drive, cruise=self._cruise)
        self._reference = PathReference(path, profile, turn_first=TURN_FIRST)
        self._reference.s = 0.0  # or a round trip would be over before it began
        self._cross_track = 0.0

    def pose(self) -> Pose2 | None:
        """Where the robot is, in the world frame; None while nobody knows, when it must `brake`.

        Raises:
            ActionFailed: LOST_POSE, if it stays lost.
        """
        return self._watch.look(self._body)

    def standing(self) -> bool:
        """Whether the wheels stand; true where nobody measures them."""
        return not bool(np.any(np.abs(self._body.knowledge.robot.wheel_speeds()) > STANDING))

    def step(self, pose: Pose2) -> Action:
        """This period's command, as the action that gives it; the path must have begun."""
        if self._reference is None:
            return self.brake()
        return self.follow(pose, self._reference)

    def follow(self, pose: Pose2, reference: Reference) -> Action:
        """This period's command for any reference, as the action that gives it."""
        body = self._body
        command = body.follower.step(pose, self._wheels(), reference, body.period)
        if math.isfinite(command.cross_track):
            self._cross_track = command.cross_track
            body.note(
                Followed,
                cross_track=command.cross_track,
                heading_error=command.heading_error,
                rung=command.rung,
                solve_time=command.solve_time if math.isfinite(command.solve_time) else 0.0,
            )
        return SetWheelSpeed(speeds=command.wheel_speeds.tolist(), duration=body.period)

    def brake(self) -> Action:
        """Standstill for this period."""
        self._owns_wheels = False
        return SetWheelSpeed(speeds=[0.0] * len(self._body.drive.wheels), duration=self._body.period)

    def _wheels(self) -> Array | None:
        """(w,) Measured rim speeds [m/s] when somebody else drove before; None while the follower knows them."""
        if self._owns_wheels:
            return None
        self._owns_wheels = True
        speeds = self._body.knowledge.robot.wheel_speeds()
        return speeds if bool(np.isfinite(speeds).all()) else None
