"""GoTo: drive straight to a goal of the world model."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated

from ..base.units import NOT_NEGATIVE, Metres, PositiveMetresPerSecond
from ..control.path import Path
from ..interfaces.action import Action, ActionFailed, Body, Reason
from .heading import ALONG
from .path_action import Height, PathAction
from .pose import GoalAction, goal_pose, goal_tolerance

MOVED = 0.05  # [m] displacement of the goal that triggers a new path
ARRIVED = 0.05  # [m] greatest distance from a goal of any tolerance at which the robot has arrived
MISSES = 5  # number of paths that may end away from the goal before the action fails


class GoTo(GoalAction, PathAction):
    """Drive straight to a goal with the follower and stop there; reflexes handle obstacles.

    If the heading error exceeds 60 deg, the robot first turns on the spot, unless it has another heading than `along`:
    then it turns while it drives. A moving goal is followed. The goal is the pursued goal of the world model, to which
    `goal_distance` refers, until the action succeeds or fails.

    Attributes:
        goal: Node of the world model with a pose.
        cruise: Speed on straight parts [m/s].
        tolerance: Distance from the goal at which the stationary robot has arrived, also in height; 0 for 0.05 m, or
            less if the goal's tolerance is less [m].
        heading: Yaw on the way: `along` the path, `keep`, an angle such as `90 deg`, or `look_at PLACE`.
            An angle holds on arrival, too, within 5 deg.
        height: Height to fly at [m], 0.15 m away from what `above` and `below` detect; no change by default.
    """

    goal: str
    cruise: PositiveMetresPerSecond = 0.5
    tolerance: Annotated[Metres, NOT_NEGATIVE] = 0.0
    heading: str = ALONG
    height: Height = math.inf

    def _drive_to_goal(self, body: Body) -> Iterator[Action]:
        drive, planned, misses = self.path_drive(body, self.cruise), None, 0
        tolerance = self.tolerance or min(ARRIVED, goal_tolerance(body, self.goal))
        near = tolerance + body.locomotion.sway
        while True:
            goal, pose = goal_pose(body, self.goal), drive.pose()
            if pose is None:
                yield drive.brake()
                continue
            distance = pose.distance(goal)
            there = distance <= near and drive.at_height(tolerance) and drive.faces(pose)
            if there and drive.stationary():
                return
            missed = drive.remaining < 0.5 * tolerance and distance > near
            if missed and (misses := misses + 1) > MISSES:
                raise ActionFailed(Reason.STUCK, f"missed '{self.goal}' {MISSES} times, now {distance:.2f} m away")
            if planned is None or missed or drive.lost or planned.distance(goal) > MOVED:
                drive.begin(Path.line(pose, goal))
                planned = goal
            yield drive.step(pose)
