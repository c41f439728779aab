"""Conditions of Nav2 (nav2_behavior_tree, plugins/condition) that do not need ROS."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from ...geometry import Pose2
from ...trees.board import from_string
from ...trees.nodes import FAILURE, SUCCESS, Input, Instant, Outcome
from ..context import mission_of
from .decorators import goals_of, value_of
from .poses import PoseInput, PosesInput, pose_of, robot_pose, same
from .run_aware import RunAwareCondition


class _Condition(Instant):
    kind = "Condition"

    def update(self) -> Outcome:
        return SUCCESS if self.holds() else FAILURE

    def holds(self) -> bool:
        """Whether the condition is true."""
        raise NotImplementedError


class _RelativeCondition(RunAwareCondition):
    """Base of conditions relative to a reference state: that at the beginning of the run, or when last true."""

    def update(self) -> Outcome:
        if self.begins():
            self.restart()
            return FAILURE
        if not self.holds():
            return FAILURE
        self.restart()
        return SUCCESS

    def restart(self) -> None:
        """Store the current state as the new reference."""
        raise NotImplementedError

    def holds(self) -> bool:
        """Whether the condition is true."""
        raise NotImplementedError


class GoalUpdated(_RelativeCondition):
    """SUCCESS if the goal has changed since the last tick; FAILURE in the first tick."""

    goal = PoseInput(None, "the goal; the key `goal` by default")
    goals = PosesInput(None, "the goals; the key `goals` by default")

    def restart(self) -> None:
        self._goals = goals_of(self)

    def holds(self) -> bool:
        return not same(goals_of(self), self._goals)


class GlobalUpdatedGoal(_Condition):
    """SUCCESS in its very first tick, and if the goal has changed since its last tick; a new run does not reset it."""

    goal = PoseInput(None, "the goal; the key `goal` by default")
    goals = PosesInput(None, "the goals; the key `goals` by default")
    _goals: list[Any] | None = None

    def holds(self) -> bool:
        now = goals_of(self)
        changed = self._goals is None or not same(now, self._goals)
        self._goals = now
        return changed


class TimeExpired(_RelativeCondition):
    """SUCCESS if a time has passed since the first tick, or since the condition was last true."""

    seconds = Input(float, 1.0, "time [s]")

    def restart(self) -> None:
        self._since = self.runtime.now()

    def holds(self) -> bool:
        return self.runtime.now() - self._since >= self.seconds - 1e-9


class DistanceTraveled(_RelativeCondition):
    """SUCCESS if the robot has moved a distance since the first tick, or since the condition was last true."""

    distance = Input(float, 1.0, "distance [m]")
    global_frame = Input(str, "map", "frame in Nav2; here the world frame")
    robot_base_frame = Input(str, "base_link", "frame in Nav2; not used")

    def restart(self) -> None:
        self._at = robot_pose(mission_of(self))

    def holds(self) -> bool:
        return robot_pose(mission_of(self)).distance(self._at) >= self.distance


class PathExpiringTimer(_RelativeCondition):
    """SUCCESS if a path has not changed for a time."""

    seconds = Input(float, 1.0, "time [s]")
    path = Input(list, "{path}", "path")

    def restart(self) -> None:
        self._since, self._path = self.runtime.now(), value_of(self, "path")

    def holds(self) -> bool:
        if value_of(self, "path") is not self._path:
            self.restart()
        return self.runtime.now() - self._since >= self.seconds - 1e-9


class GoalReached(_Condition):
    """SUCCESS if the robot is at the goal, within the tolerance of its node."""

    goal = PoseInput("{goal}", "goal")
    robot_base_frame = Input(str, "base_link", "frame in Nav2; not used")

    def holds(self) -> bool:
        mission, goal = mission_of(self), self.goal
        pose = pose_of(mission, goal)
        known = isinstance(goal, str) and mission.knowledge.graph.has(goal)
        tolerance = mission.knowledge.graph.attributes(goal).get("tolerance") if known else None
        return pose is not None and robot_pose(mission_of(self)).distance(pose) <= (tolerance or TOLERANCE)


TOLERANCE = 0.25
"""Tolerance of a goal if its node declares none [m]."""


class ArePosesNear(_Condition):
    """SUCCESS if two poses are within a distance of each other."""

    ref_pose = PoseInput(None, "first pose; the robot's pose by default")
    target_pose = PoseInput("{goal}", "second pose")
    global_frame = Input(str, "map", "frame in Nav2; here the world frame")
    tolerance = Input(float, 0.5, "distance [m]")

    def holds(self) -> bool:
        mission, given = mission_of(self), self.ref_pose
        one = robot_pose(mission_of(self)) if given is None else pose_of(mission, given)
        other = pose_of(mission, self.target_pose)
        return one is not None and other is not None and one.distance(other) <= self.tolerance


class IsStuck(RunAwareCondition):
    """SUCCESS if the robot has moved less than 0.1 m for at least 3 s."""

    _at: Pose2
    _since: float

    def update(self) -> Outcome:
        mission, now = mission_of(self), self.runtime.now()
        here = robot_pose(mission)
        if self.begins() or not here.distance(self._at) < 0.1:
            self._at, self._since = here, now
        return SUCCESS if now - self._since >= 3.0 else FAILURE


class IsStopped(RunAwareCondition):
    """SUCCESS if the robot has been slower than a threshold for a time."""

    velocity_threshold = Input(float, 0.01, "speed threshold [m/s]")
    duration_stopped = Input(int, 1000, "time [ms]")

    def update(self) -> Outcome:
        mission, now = mission_of(self), self.runtime.now()
        speed = abs(mission.knowledge.robot.speed(mission.clock.now()))
        if self.begins() or not speed <= self.velocity_threshold:
            self._since = now
        return SUCCESS if now - self._since >= self.duration_stopped / 1000.0 - 1e-9 else FAILURE


class InitialPoseReceived(_Condition):
    """SUCCESS if the robot's pose is known."""

    initial_pose_received = Input(bool, False, "key of Nav2; here the pose itself is used")

    def holds(self) -> bool:
        return not math.isnan(robot_pose(mission_of(self)).x)


class TransformAvailable(InitialPoseReceived):
    """SUCCESS if the robot's pose is known: there are no other transforms than world to robot here."""

    child = Input(str, "", "frame in Nav2; not used")
    parent_frame = Input(str, "", "frame in Nav2; not used", name="parent")


class _ErrorCodeCondition(_Condition):
    """Base of conditions on an error code; FAILURE if the node that writes the code has not run yet."""

    helped: ClassVar[tuple[int, ...]] = ()
    error_code = Input(int, None, "error code of the node that failed")

    def holds(self) -> bool:
        return self.error_code in self.helped


class WouldAPlannerRecoveryHelp(_ErrorCodeCondition):
    """SUCCESS if a recovery may help after this error code of ComputePathToPose or ComputePathThroughPoses."""

    helped = (200, 207, 208, 300, 307, 308)


class WouldAControllerRecoveryHelp(_ErrorCodeCondition):
    """SUCCESS if a recovery may help after this error code of FollowPath."""

    helped = (100, 104, 105, 106)


def _numbers(text: str) -> list[int]:
    parts = text.replace(",", ";").split(";")
    return [from_string(part.strip(), int) for part in parts if part.strip()]


class WouldARouteRecoveryHelp(_ErrorCodeCondition):
    """SUCCESS if a recovery may help after this error code of ComputeRoute."""

    helped = (400, 404, 405)


class AreErrorCodesPresent(_Condition):
    """SUCCESS if an error code is in a list of error codes."""

    error_code = Input(int, None, "error code; FAILURE if missing")
    error_codes_to_check = Input(list[int], doc="error codes to look for, separated by `;` or `,`", parse=_numbers)

    def holds(self) -> bool:
        return self.error_code in self.error_codes_to_check
