"""GoTo: drive to a place that Knowledge knows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..action import Action, ActionFailed, Body, MacroAction, Reason
from ..control.path import Path
from ..errors import did_you_mean
from ..geometry import Pose2
from ..units import PositiveMetres, PositiveMetresPerSecond
from .following import PathDrive

if TYPE_CHECKING:
    from ..knowledge import Knowledge

MOVED = 0.05  # [m] A goal that moved so far gets a new path.
MISSES = 5  # A robot that ends its path so often without reaching the goal never will.


@dataclass(kw_only=True, eq=False)
class GoTo(MacroAction):
    """Drive straight to a goal and stand there, with the follower; obstacles on the way are the reflexes' matter.

    The robot turns on the spot first when it looks elsewhere by more than 60 deg. A goal that moves is followed. While
    it drives the goal is the one that the world model pursues, so that `goal_distance` means it; that stays so when
    a reflex cuts in, and ends with success or failure.

    Attributes:
        goal: A node of the world model that has a pose.
        cruise: Speed on the straight [m/s].
        tolerance: Distance from the goal at which it is reached, standing [m].
    """

    goal: str
    cruise: PositiveMetresPerSecond = 0.5
    tolerance: PositiveMetres = 0.05

    def decompose(self, body: Body) -> Iterator[Action]:
        world = body.knowledge.world
        goal_pose(body, self.goal)
        if self.goal in world.goals():
            world.pursue(self.goal)
        try:
            yield from self._drive(body)
        except ActionFailed:
            self._give_up(body)
            raise
        self._give_up(body)

    def remaining(self, knowledge: Knowledge) -> float:
        goal = knowledge.world.pose_of(self.goal)
        return math.nan if goal is None else knowledge.robot.pose().distance(goal)

    def _drive(self, body: Body) -> Iterator[Action]:
        drive, planned, misses = PathDrive(body, self.cruise), None, 0
        while True:
            goal, pose = goal_pose(body, self.goal), drive.pose()
            if pose is None:
                yield drive.brake()
                continue
            distance = pose.distance(goal)
            if distance <= self.tolerance and drive.standing():
                return
            missed = drive.remaining < 0.5 * self.tolerance and distance > self.tolerance
            if missed and (misses := misses + 1) > MISSES:
                raise ActionFailed(Reason.STUCK, f"missed '{self.goal}' {MISSES} times, now {distance:.2f} m away")
            if planned is None or missed or drive.lost or planned.distance(goal) > MOVED:
                drive.begin(Path.line(pose, goal))
                planned = goal
            yield drive.step(pose)

    def _give_up(self, body: Body) -> None:
        if body.knowledge.world.pursued() == self.goal:
            body.knowledge.world.pursue(None)


def goal_pose(body: Body, goal: str) -> Pose2:
    """Where a goal is, in the world frame.

    Raises:
        ActionFailed: NO_GOAL, where nobody knows.
    """
    world = body.knowledge.world
    pose = world.pose_of(goal)
    if pose is None:
        hint = did_you_mean(goal, [*world.goals(), *world.places()], "The world")
        raise ActionFailed(Reason.NO_GOAL, f"nothing named '{goal}' has a known place. {hint}")
    return pose
