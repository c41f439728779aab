"""Dock: drive to a docking pose with centimetre accuracy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated

import numpy as np

from ..base.geometry import Pose2, Twist2, wrap_angle
from ..base.units import NOT_NEGATIVE, Metres, PositiveMetres, PositiveMetresPerSecond, PositiveRadians
from ..control.path import Path
from ..interfaces.action import Action, ActionFailed, Body, Reason
from .path_drive import PathDrive
from .pose import GoalAction, goal_pose
from .set_twist import hold
from .stop import Stop
from .turn import TurnTo

READY = 0.05
"""Distance from the staging pose at which this pose counts as reached [m]."""


class Dock(GoalAction):
    """Drive to a staging pose in front of a dock, turn, and creep in; if misaligned, back out and try again.

    The pose of the dock in the world model is the pose of the docked robot. The robot is docked when it is stationary
    at that pose, or when the signal `front` reports contact. Put reflexes that would keep the robot away from the dock
    into another mode: see `Mission.enter`.

    Attributes:
        goal: Node of the dock.
        staging: Distance from the staging pose to the dock [m].
        cruise: Speed to the staging pose [m/s].
        creep: Speed from the staging pose to the dock [m/s].
        tolerance: Position error of the docked robot, along the heading of the dock and across it [m].
        facing: Heading error of the docked robot [rad].
        touch: Range ahead that counts as contact; 0 disables it [m].
        attempts: Maximum number of attempts.
    """

    goal: str
    staging: PositiveMetres = 0.6
    cruise: PositiveMetresPerSecond = 0.4
    creep: PositiveMetresPerSecond = 0.1
    tolerance: PositiveMetres = 0.03
    facing: PositiveRadians = 0.1
    touch: Annotated[Metres, NOT_NEGATIVE] = 0.0
    attempts: int = 3
    _ahead: float = math.inf

    def _drive_to_goal(self, body: Body) -> Iterator[Action]:
        missed = ""
        for attempt in range(1, self.attempts + 1):
            dock = goal_pose(body, self.goal)
            staging = Pose2(*dock.transform(-self.staging, 0.0), dock.yaw)
            yield from self._drive(body, staging, self.cruise, READY)
            yield TurnTo(yaw=dock.yaw)
            yield from self._drive(body, dock, self.creep, self.tolerance, touch=self.touch)
            missed = self._missed(body, dock)
            if not missed:
                return
            if attempt < self.attempts:
                # Rounded, so that wheels turn exactly alike on the way straight back.
                back = np.round(body.locomotion.command(Twist2(-self.creep)), 12)
                yield hold(body, back.tolist(), 0.5 * self.staging / self.creep)
        raise ActionFailed(Reason.STUCK, f"missed '{self.goal}' {self.attempts} times; last error: {missed}")

    def _drive(
        self, body: Body, to: Pose2, speed: float, tolerance: float, touch: float | None = None
    ) -> Iterator[Action]:
        """Drive straight to a pose until the robot is stationary there, has passed it, or has contact.

        Args:
            body: Robot.
            to: Pose to reach, world frame.
            speed: Speed [m/s].
            tolerance: Distance from the pose at which it is reached [m].
            touch: Range ahead that counts as contact [m]; 0 or None disables contact.
        """
        drive, begun = PathDrive(body, speed), False
        while True:
            pose = drive.pose()
            if pose is None:
                yield drive.brake()
                continue
            ahead, _ = _offset(to, pose)
            arrived = pose.distance(to) <= tolerance or (begun and drive.remaining < 0.5 * tolerance)
            if touch is not None and self._touches(body, touch):
                if -ahead > 0.5 * self.staging:
                    evidence = f"front = {self._ahead:.2f} m, {-ahead:.2f} m before '{self.goal}'"
                    raise ActionFailed(Reason.BLOCKED, evidence)
                yield Stop()
                return
            if arrived and (not begun or drive.stationary()):
                return
            if not begun or drive.lost:
                drive.begin(Path.line(pose, to))
                begun = True
            yield drive.step(pose)

    def _touches(self, body: Body, touch: float) -> bool:
        signals = body.knowledge.signals
        if touch == 0.0:
            return False
        if "front" not in signals:
            raise ActionFailed(Reason.LOST_SENSOR, "touch needs the signal 'front', which this robot does not have")
        beams = [float(value) for value in signals.read("front", body.clock.now())]
        if all(map(math.isnan, beams)):
            raise ActionFailed(Reason.LOST_SENSOR, "the signal 'front' is invalid, and touch needs it")
        self._ahead = min(value for value in beams if not math.isnan(value))
        return self._ahead <= touch

    def _missed(self, body: Body, dock: Pose2) -> str:
        """Text about an error above its tolerance; empty if docked. With contact, the error ahead is ignored."""
        pose = body.knowledge.robot.pose(body.clock.now())
        along, aside = _offset(dock, pose)
        skew = abs(wrap_angle(pose.yaw - dock.yaw))
        touches = self.touch > 0.0 and self._ahead <= self.touch
        if abs(aside) > self.tolerance:
            return f"{abs(aside):.3f} m aside"
        if skew > self.facing:
            return f"{math.degrees(skew):.1f} deg"
        return "" if touches or abs(along) <= self.tolerance else f"{abs(along):.3f} m along"


def _offset(dock: Pose2, pose: Pose2) -> tuple[float, float]:
    """Offset of a pose in the frame of the dock: ahead and left [m]."""
    x, y = pose.x - dock.x, pose.y - dock.y
    c, s = math.cos(dock.yaw), math.sin(dock.yaw)
    return c * x + s * y, c * y - s * x
