"""Motion actions of Nav2, implemented with the robot's actions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, ClassVar

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2, wrap_angle
from ..interfaces.action import Action, Failure, Reason, make_action
from ..knowledge import segment_distance
from ..plan.action_node import ActionNode
from ..plan.waits import until
from ..trees.nodes import FAILURE, RUNNING, SUCCESS, Leaf, Outcome, Output
from .path import corners_of, poses_in
from .poses import robot_pose
from .servers import Cancellable

CRUISE = 0.5
"""Cruise speed of FollowPath [m/s]."""

SPIN_RATE = 1.0
"""Turn rate of Spin [rad/s]."""

PATH_END = " path_end"
"""Name of the place at the end of a path, if no goal is there; the space avoids a clash with names in files."""

_CODES = {Reason.TIMEOUT: 1, Reason.LOST_POSE: 2, Reason.BLOCKED: 3, Reason.STUCK: 3}


@dataclass(frozen=True)
class TrackingFeedback:
    """Robot's position and error relative to a path, as in nav2_msgs/TrackingFeedback.

    Attributes:
        robot_pose: Pose of the robot, world frame.
        position_tracking_error: Distance from the path, left positive [m].
        heading_tracking_error: Heading relative to the nearest leg of the path, left positive [rad].
        current_path_index: Index of the corner at which the nearest leg begins.
        remaining_path_length: Length of the path from the point nearest to the robot to the end [m].
        distance_to_goal: Straight distance from the robot to the end of the path [m].
        speed: Speed of the robot [m/s].
    """

    robot_pose: Pose2
    position_tracking_error: float
    heading_tracking_error: float
    current_path_index: int
    remaining_path_length: float
    distance_to_goal: float
    speed: float


def track(path: Sequence[Sequence[float]], pose: Pose2, speed: float) -> TrackingFeedback:
    """Compute the robot's position and error relative to a path.

    Args:
        path: Corners, (x, y) in the world frame [m].
        pose: Pose of the robot, world frame.
        speed: Speed of the robot [m/s].
    """
    corners = [(point[0], point[1]) for point in path]
    corners = corners if len(corners) > 1 else corners * 2
    legs = [(math.dist(a, b), a, b) for a, b in pairwise(corners)]
    away, index = min((segment_distance((pose.x, pose.y), a, b), i) for i, (_, a, b) in enumerate(legs))
    length, (ax, ay), (bx, by) = legs[index]
    ux, uy = ((bx - ax) / length, (by - ay) / length) if length > 0.0 else (math.cos(pose.yaw), math.sin(pose.yaw))
    along, across = (pose.x - ax) * ux + (pose.y - ay) * uy, (pose.y - ay) * ux - (pose.x - ax) * uy
    left = length - min(max(along, 0.0), length) + sum(leg[0] for leg in legs[index + 1 :])
    return TrackingFeedback(
        robot_pose=pose,
        position_tracking_error=math.copysign(away, across),
        heading_tracking_error=wrap_angle(pose.yaw - math.atan2(uy, ux)),
        current_path_index=index,
        remaining_path_length=left,
        distance_to_goal=math.dist((pose.x, pose.y), corners[-1]),
        speed=speed,
    )


class _Move(Cancellable, ActionNode):
    """Base of nodes that execute one action of the robot and report its failure as an error code of nav2_msgs."""

    base: ClassVar[int] = 0
    codes: ClassVar[dict[Reason, int]] = _CODES

    def parameters(self) -> dict[str, Any]:
        """Parameters of the action, in SI units."""
        raise NotImplementedError

    def initialise(self) -> None:
        self._refused: Failure | None = None
        super().initialise()

    def update(self) -> Any:
        if self.cancelled:
            if self.ticket is not None:
                self.mission.pipeline.cancel(self.ticket, by=self.mission.path(self))
            self._drop_goal()
            self.put_error()
            return SUCCESS
        outcome = super().update() if self._refused is None else self._fail(self._refused)
        if outcome is SUCCESS:
            self.put_error()
        return outcome

    def _submit(self, interrupted: Action | None = None) -> None:
        try:
            super()._submit(interrupted)
        except InputError as error:  # as in Nav2, where a server rejects the goal: the node fails
            self.ticket, self._refused = None, Failure.cannot(error)

    def bound_faults(self) -> Any:
        return ()  # the parameters are known only when the action is created

    def _made(self) -> Action:
        self._submitted = self.parameters()
        return make_action(self.mission.actions, self.action, self._submitted)

    def _fail(self, failure: Failure) -> Any:
        self.put_error(self.base + self.codes.get(failure.reason, 0), str(failure))
        return super()._fail(failure)


class _TimeLimited(_Move):
    """Base of motion nodes that fail after `time_allowance`."""

    time_allowance: Annotated[float, "maximum duration [s]"] = 10.0
    disable_collision_checks: Annotated[bool, "whether Nav2 does not check; reflexes are always active"] = False

    def initialise(self) -> None:
        self._until = self.runtime.now() + self.time_allowance
        super().initialise()

    def update(self) -> Any:
        outcome = super().update()
        if outcome is RUNNING and self.time_allowance > 0.0 and self.runtime.now() > self._until:
            return self._fail(Failure(Reason.TIMEOUT, f"after {self.time_allowance:g} s"))
        return outcome

    def wait_text(self) -> str:
        return until(self._until if self.time_allowance > 0.0 else math.inf, super().wait_text())


EMPTY = "the path is empty"
"""Evidence of a failure without a path."""

TELEOP_TIMEOUT = 731
"""Error code of AssistedTeleop at the end of its time."""


class FollowPath(_Move):
    """Follows a path. If the key of the path gets a new path while the robot drives, the robot follows the new one."""

    action = "FollowRoute"
    base = 100
    codes: ClassVar[dict[Reason, int]] = {
        Reason.LOST_POSE: 2,
        Reason.CANNOT: 3,
        Reason.TIMEOUT: 7,
        Reason.STUCK: 5,
        Reason.BLOCKED: 6,
    }

    path: Annotated[Any, "path; also corners, (x, y) in the world frame [m]"] = "{path}"
    controller_id: Annotated[str, "name of a controller; for a running Nav2 only"] = ""
    goal_checker_id: Annotated[str, "name of a goal checker; for a running Nav2 only"] = ""
    progress_checker_id: Annotated[str, "name of a progress checker; for a running Nav2 only"] = ""
    path_handler_id: Annotated[str, "name of a path handler; for a running Nav2 only"] = ""
    tracking_feedback: Annotated[Output[Any], "position on the path, in each tick"]
    empty_code = 1
    """Error code for an empty path: Nav2 rejects such a goal since Lyrical."""

    def parameters(self) -> dict[str, Any]:
        self._path = self.path
        points = corners_of(self._path)
        return {"points": points, "goal": self._goal(points), "cruise": min(CRUISE, self._fastest())}

    def _submit(self, interrupted: Action | None = None) -> None:
        if poses_in(self.path):
            super()._submit(interrupted)
        else:
            self.ticket, self._refused = None, Failure(Reason.CANNOT, EMPTY)

    def update(self) -> Any:
        ticket, path = self.ticket, self.path
        if ticket is not None and not ticket.state.done and path is not self._path and (points := corners_of(path)):
            if math.dist(points[-1][:2], corners_of(self._path)[-1][:2]) > 1e-6:
                self._drop_goal()
                self.mission.pipeline.cancel(ticket, by=self.mission.path(self))
                self._submit()
                return RUNNING
            if points is not corners_of(self._path):
                self.mission.pipeline.update(ticket, {"points": points})
            self._path = path
        outcome = super().update()
        self._track(outcome)
        return outcome

    def _fail(self, failure: Failure) -> Any:
        outcome = super()._fail(failure)
        if self.ticket is None and failure is self._refused and failure.evidence == EMPTY:
            self.put_error(self.empty_code, str(failure))
        return outcome

    def _track(self, outcome: Outcome) -> None:
        """Write the feedback: position on the path while RUNNING, zeros at the end."""
        if self.key("tracking_feedback") is None or not (path := poses_in(self._path)):
            return
        robot, mission = self.mission.knowledge.robot, self.mission
        found = track(path, robot_pose(mission), robot.speed(mission.clock.now()))
        self.tracking_feedback = found if outcome is RUNNING else TrackingFeedback(found.robot_pose, *[0] * 6)

    def _fastest(self) -> float:
        known = self.mission.knowledge.graph.attributes(self.mission.knowledge.agent)
        return float(known.get("speed_limit", math.inf))

    def _goal(self, path: Any) -> str:
        """Name of the goal at the end of a path; if there is none in the world model, a place is added."""
        x, y = path[-1][:2]
        world, end = self.mission.knowledge.world, Pose2(x, y, 0.0)
        for name in world.goals():
            pose = world.pose_of(name)
            if pose is not None and math.hypot(pose.x - end.x, pose.y - end.y) < 1e-6:
                return name
        world.place(PATH_END, end)
        return PATH_END


class Spin(_TimeLimited):
    """Turns on the spot."""

    action = "TurnAngle"
    base = 700
    spin_dist: Annotated[float, "angle, left positive [rad]"] = 1.57
    is_recovery: Annotated[bool, "whether Nav2 counts it as a recovery; not used"] = True

    def parameters(self) -> dict[str, Any]:
        return {"angle": self.spin_dist, "rate": SPIN_RATE}


class DriveOnHeading(_TimeLimited):
    """Drives straight for a distance, backward if distance and speed are negative."""

    action = "Flinch"
    base = 720
    codes: ClassVar[dict[Reason, int]] = {**_CODES, Reason.CANNOT: 4}
    dist_to_travel: Annotated[float, "distance [m]"] = 0.15
    speed: Annotated[float, "speed [m/s]"] = 0.025

    def parameters(self) -> dict[str, Any]:
        if self.speed * self.dist_to_travel < 0.0:
            raise InputError(Fault("the signs of distance and speed differ."))
        speed = math.copysign(self.speed, self.dist_to_travel)
        return {"speed": speed, "distance": abs(self.dist_to_travel), "timeout": self.time_allowance}


class BackUp(_TimeLimited):
    """Drives backward for a distance, regardless of the signs of distance and speed."""

    action = "Flinch"
    base = 710
    codes: ClassVar[dict[Reason, int]] = {**_CODES, Reason.BLOCKED: 4, Reason.STUCK: 4, Reason.CANNOT: 3}
    backup_dist: Annotated[float, "distance [m]"] = 0.15
    backup_speed: Annotated[float, "speed [m/s]"] = 0.025

    def parameters(self) -> dict[str, Any]:
        speed = -abs(self.backup_speed)
        return {"speed": speed, "distance": abs(self.backup_dist), "timeout": self.time_allowance}


class Wait(Cancellable, Leaf):
    """RUNNING for a duration, then SUCCESS; a negative duration counts as a positive one."""

    wait_duration: Annotated[float, "duration [s]"] = 1.0

    def initialise(self) -> None:
        super().initialise()
        self._until = self.runtime.now() + abs(self.wait_duration)

    def update(self) -> Outcome:
        if not self.cancelled and self.runtime.now() < self._until - 1e-9:
            return RUNNING
        self.put_error()
        return SUCCESS

    def wait_text(self) -> str:
        return until(self._until) if self.status is RUNNING else ""


class AssistedTeleop(Cancellable, Leaf):
    """RUNNING for `time_allowance`: there is no operator here. Then FAILURE if `is_recovery`, else SUCCESS."""

    time_allowance: Annotated[float, "duration [s]"] = 10.0
    is_recovery: Annotated[bool, "whether the node fails at the end"] = False

    def initialise(self) -> None:
        super().initialise()
        self._until = self.runtime.now() + self.time_allowance

    def wait_text(self) -> str:
        return until(self._until) if self.status is RUNNING else ""

    def update(self) -> Outcome:
        if self.cancelled:
            self.put_error()
            return SUCCESS
        if self.runtime.now() < self._until - 1e-9:
            return RUNNING
        self.put_error(TELEOP_TIMEOUT, f"after {self.time_allowance:g} s")
        return FAILURE if self.is_recovery else SUCCESS
