"""Poses for motion actions: that of the robot, with short losses tolerated, and that of a goal that is pursued."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..base.errors import did_you_mean
from ..base.geometry import Pose2
from ..interfaces.action import Action, ActionFailed, Body, MacroAction, Reason

if TYPE_CHECKING:
    from ..knowledge import Knowledge

PATIENCE = 5
"""Number of consecutive periods without a pose for which a motion action waits at standstill."""


class PoseWatch:
    """Reader of the robot's pose that counts consecutive periods without a pose; each action has its own."""

    def __init__(self) -> None:
        self._lost = 0

    def read(self, body: Body) -> Pose2 | None:
        """Pose of the robot, world frame; None while it is lost. While it is None, the action must stop the wheels.

        Raises:
            ActionFailed: LOST_POSE, once the pose has been lost for more than `PATIENCE` periods.
        """
        pose = body.knowledge.robot.pose(body.clock.now())
        if all(map(math.isfinite, pose)):
            self._lost = 0
            return pose
        self._lost += 1
        if self._lost > PATIENCE:
            seconds = self._lost * body.period
            raise ActionFailed(Reason.LOST_POSE, f"the signal 'pose' has been invalid for {seconds:.2f} s")
        return None


TOLERANCE = 0.1
"""Distance at which a node without an attribute `tolerance` is reached [m]."""

ARRIVED = 0.9
"""Share of a goal's tolerance within which a robot must be, so that it is there in spite of the noise of its pose."""


def goal_tolerance(body: Body, goal: str, declared: float = 0.0) -> float:
    """Distance from a goal at which an action has reached it [m].

    Args:
        body: Robot.
        goal: Node of the world model.
        declared: The action's own tolerance [m]; 0 for that of the goal.
    """
    if declared > 0.0:
        return declared
    graph = body.knowledge.graph
    known = graph.attributes(goal).get("tolerance") if graph.has(goal) else None
    return TOLERANCE if known is None else ARRIVED * float(known)


def goal_pose(body: Body, goal: str) -> Pose2:
    """Pose of a goal, world frame.

    Raises:
        ActionFailed: NO_GOAL, if it is not known.
    """
    world = body.knowledge.world
    pose = world.pose_of(goal)
    if pose is None:
        hint = did_you_mean(goal, [*world.goals(), *world.places()], "The world")
        raise ActionFailed(Reason.NO_GOAL, f"no node '{goal}' with a known pose. {hint}")
    return pose


class GoalAction(MacroAction):
    """Base class of actions that drive to a node of the world model; its subclasses declare the parameter `goal`.

    The action makes the goal the pursued goal of the world model, to which `goal_distance` refers. It stays the pursued
    goal during a reflex and is released when the action succeeds or fails.

    Attributes:
        goal: Node of the world model with a pose.
    """

    # At run time each subclass declares it itself: declared here, it would come before their other parameters.
    if TYPE_CHECKING:
        goal: str

    def decompose(self, body: Body) -> Iterator[Action]:
        goal_pose(body, self.goal)
        self._pursue(body)
        try:
            yield from self._drive_to_goal(body)
        except ActionFailed:
            self._release(body)
            raise
        self._release(body)

    def remaining(self, knowledge: Knowledge) -> float:
        goal = knowledge.world.pose_of(self.goal)
        return math.nan if goal is None else knowledge.robot.pose().distance(goal)

    def _drive_to_goal(self, body: Body) -> Iterator[Action]:
        """Actions that lead to the goal."""
        raise NotImplementedError

    def _pursue(self, body: Body) -> None:
        if self.goal in body.knowledge.world.goals():
            body.knowledge.world.pursue(self.goal)

    def _release(self, body: Body) -> None:
        if body.knowledge.world.pursued() == self.goal:
            body.knowledge.world.pursue(None)
