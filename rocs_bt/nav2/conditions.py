"""Conditions of Nav2 (nav2_behavior_tree, plugins/condition) that do not need ROS."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from ..plan.context import mission_of
from ..plan.waits import until
from ..trees.nodes import FAILURE, RUNNING, SUCCESS, Instant, Leaf, Outcome, Syntax
from ..trees.nodes.node import LazyAttribute
from ..trees.value import from_string
from .decorators import GoalWatch
from .lenient import Framed, Lenient
from .path import PathSearch, length, poses_in
from .poses import PoseText, known, pose_of, robot_pose
from .run_aware import RunAwareCondition

if TYPE_CHECKING:
    from ..plan.context import MissionContext


class _Condition(Lenient, Instant):
    kind = "Condition"

    def update(self) -> Outcome:
        return SUCCESS if self.holds() else FAILURE

    def holds(self) -> bool:
        """Whether the condition is true."""
        raise NotImplementedError


class _RelativeCondition(Lenient, RunAwareCondition):
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


class GoalUpdated(GoalWatch, _RelativeCondition):
    """SUCCESS if the goal has changed since the last tick; FAILURE in the first tick."""

    def holds(self) -> bool:
        return self.changed()


class GlobalUpdatedGoal(GoalWatch, _Condition):
    """SUCCESS in its very first tick, and if the goal has changed since its last tick; a new run does not reset it."""

    _goals: Any = None

    def holds(self) -> bool:
        changed = self._goals is None or self.changed()
        self.restart()
        return changed


class TimeExpired(_RelativeCondition):
    """SUCCESS if a time has passed since the first tick, or since the condition was last true."""

    seconds: Annotated[float, "time [s]"] = 1.0

    def restart(self) -> None:
        self._since = self.runtime.now()

    def holds(self) -> bool:
        return self.runtime.now() - self._since >= self.seconds - 1e-9

    def wait_text(self) -> str:
        return until(self._since + self.seconds)


class DistanceTraveled(Framed, _RelativeCondition):
    """SUCCESS if the robot has moved a distance since the first tick, or since the condition was last true."""

    distance: Annotated[float, "distance [m]"] = 1.0

    def restart(self) -> None:
        self._at = robot_pose(mission_of(self))

    def holds(self) -> bool:
        return robot_pose(mission_of(self)).distance(self._at) >= self.distance

    def wait_text(self) -> str:
        return f"moved {robot_pose(mission_of(self)).distance(self._at):.1f} m of {self.distance:.3g} m"


class PathExpiringTimer(_Condition):
    """SUCCESS if a path has not changed for a time; a new run of the parent does not reset it."""

    seconds: Annotated[float, "time [s]"] = 1.0
    path: Annotated[Any, "path"] = "{path}"
    _state: tuple[float, Any] | None = None

    def holds(self) -> bool:
        now, path = self.runtime.now(), self.path
        if self._state is None or path is not self._state[1]:
            self._state = now, path
            return False
        expired = now - self._state[0] >= self.seconds - 1e-9
        if expired:
            self._state = now, path
        return expired


class GoalReached(Framed, _Condition):
    """SUCCESS if the robot is at the goal, within the tolerance of its node."""

    goal: Annotated[PoseText, "goal"] = "{goal}"

    def holds(self) -> bool:
        mission, goal = mission_of(self), self.goal
        pose = None if goal is None else pose_of(mission, goal)
        placed = isinstance(goal, str) and mission.knowledge.graph.has(goal)
        tolerance = mission.knowledge.graph.attributes(goal).get("tolerance") if placed else None
        return pose is not None and robot_pose(mission_of(self)).distance(pose) <= (tolerance or TOLERANCE)


TOLERANCE = 0.25
"""Tolerance of a goal if its node declares none [m]."""


class ArePosesNear(_Condition):
    """SUCCESS if two poses are within a distance of each other."""

    ref_pose: Annotated[PoseText, "first pose; the robot's pose by default"] = None
    target_pose: Annotated[PoseText, "second pose"] = "{goal}"
    global_frame: Annotated[str, "frame in Nav2; here the world frame"] = "map"
    tolerance: Annotated[float, "distance [m]"] = 0.5

    def holds(self) -> bool:
        mission, given = mission_of(self), self.ref_pose
        one = robot_pose(mission_of(self)) if given is None else pose_of(mission, given)
        target = self.target_pose
        other = None if target is None else pose_of(mission, target)
        return one is not None and other is not None and one.distance(other) <= self.tolerance


BRAKING = -10.0
"""Acceleration below which a robot counts as stuck [m/s2]: it has hit something."""


class IsStuck(_Condition):
    """SUCCESS if the robot decelerates by more than 10 m/s2, as if it had hit an obstacle."""

    _last: tuple[float, float] | None = None

    def holds(self) -> bool:
        mission = mission_of(self)
        now = mission.clock.now(), mission.knowledge.robot.speed(mission.clock.now())
        last, self._last = self._last, now
        return last is not None and now[0] > last[0] and (now[1] - last[1]) / (now[0] - last[0]) < BRAKING


class _StopTest(Lenient):
    velocity_threshold: Annotated[float, "threshold of the speed [m/s] and the turn rate [rad/s]"] = 0.01
    duration_stopped: Annotated[int, "time [ms]"] = 1000
    _since: float | None = None

    def update(self) -> Outcome:
        mission, now = mission_of(self), self.runtime.now()
        t, limit = mission.clock.now(), self.velocity_threshold
        moving = not max(abs(mission.knowledge.robot.speed(t)), abs(_turn_rate(mission, t))) < limit
        if moving:
            self._since = None
            return FAILURE
        if self._since is None:
            self._since = now
        if now - self._since > self.duration_stopped / 1000.0 + 1e-9:
            self._since = None
            return SUCCESS
        return RUNNING

    def wait_text(self) -> str:
        return "" if self._since is None else until(self._since + self.duration_stopped / 1000.0, "stationary")

    def halted(self) -> None:
        self._since = None
        super().halted()


def _turn_rate(mission: MissionContext, t: float) -> float:
    signals = mission.knowledge.signals
    return signals.value("turn_rate", t) if "turn_rate" in signals else 0.0


class IsStopped(_StopTest, Leaf):
    """SUCCESS if the robot has been stationary for a time; RUNNING before, and FAILURE while it moves."""

    kind = "Condition"


class CheckStopStatus(_StopTest, Leaf):
    """SUCCESS if the robot has been stationary for a time; RUNNING before, and FAILURE while it moves."""


class IsGoalNearby(Framed, _Condition):
    """SUCCESS if the rest of a path, from the pose nearest to the robot, is shorter than a threshold."""

    path: Annotated[Any, "path"] = "{path}"
    proximity_threshold: Annotated[float, "length of the rest [m]"] = 1.0
    max_robot_pose_search_dist: Annotated[float, "length searched after the last pose found [m]; negative: all"] = -1.0
    _search: Any = LazyAttribute(lambda node: PathSearch())

    def holds(self) -> bool:
        path, here = poses_in(self.path), known(robot_pose(mission_of(self)))
        if not path or here is None:
            return False
        at = self._search.find(path, here, self.max_robot_pose_search_dist, last=True)
        return length(path[at:]) < self.proximity_threshold


class IsWithinPathTrackingBounds(_Condition):
    """SUCCESS if the robot is near its path, and before FollowPath has written its first `tracking_feedback`."""

    max_error_left: Annotated[float, "maximum distance to the left of the path [m]"] = 0.5
    max_error_right: Annotated[float, "maximum distance to the right of the path [m]"] = 0.5
    max_error_heading: Annotated[float, "maximum error of the heading [rad]"] = 3.14
    tracking_feedback: Annotated[Any, "output of FollowPath"] = None

    def holds(self) -> bool:
        found = self.tracking_feedback
        if not found:
            return True
        across, heading = (_field(found, f"{n}_tracking_error") for n in ("position", "heading"))
        limit = self.max_error_left if across >= 0.0 else self.max_error_right
        return abs(across) <= abs(limit) and abs(heading) <= abs(self.max_error_heading)


def _field(value: Any, name: str) -> float:
    return float(value[name] if isinstance(value, Mapping) else getattr(value, name))


class InitialPoseReceived(_Condition):
    """SUCCESS if the robot's pose is known."""

    initial_pose_received: Annotated[bool, "key of Nav2; here the pose itself is used"] = False

    def holds(self) -> bool:
        return not math.isnan(robot_pose(mission_of(self)).x)


class TransformAvailable(InitialPoseReceived):
    """SUCCESS if the robot's pose is known: there are no other transforms than world to robot here."""

    child: Annotated[str, "frame in Nav2; not used"] = ""
    parent_: Annotated[str, "frame in Nav2; not used"] = ""


def _numbers(text: str) -> list[int]:
    parts = text.replace(",", ";").split(";")
    return [from_string(part.strip(), int) for part in parts if part.strip()]


class AreErrorCodesPresent(_Condition):
    """SUCCESS if an error code is in a list of error codes."""

    error_code: Annotated[int | None, "error code; FAILURE if missing"] = None
    error_codes_to_check: Annotated[list[int], Syntax(_numbers), "error codes to look for, separated by `;` or `,`"]

    def holds(self) -> bool:
        return self.error_code in (self.error_codes_to_check or ())
