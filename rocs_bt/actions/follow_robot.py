"""FollowRobot: follow another robot at a distance (paper, 6.5)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated

import numpy as np

from ..base.errors import Fault, InputError, did_you_mean
from ..base.geometry import Pose2, Twist2, wrap_angle
from ..base.units import (
    Bounds,
    PositiveMetres,
    PositiveMetresPerSecond,
    PositiveRadiansPerSecond,
    PositiveSeconds,
    Seconds,
)
from ..control.arcs import along
from ..control.locomotion import Array
from ..control.reference import Reference, TimedReference, TurnReference
from ..interfaces.action import Action, ActionFailed, Body, Reason
from .course import Course
from .give_way import GiveWay, trailer_path
from .heading import ALONG
from .path_action import Height, PathAction
from .path_drive import TURN_FIRST, PathDrive
from .room import Room, free_turn, may_turn
from .set_twist import hold_twist

STEP = 0.1  # [s] between poses of the planned path
AHEAD = 2.5  # [s] duration of the planned path: the follower's horizon plus the lag of the wheels
AFAR = 5.0  # [s] prediction of the leader while the robot gives way
MOVED = 0.2  # [m] displacement after which a leader counts as moving
STILL = 0.02  # [m] shorter paths are ignored, because the wheels would only creep
START = 0.08  # [m] the same for a stationary robot; the error of the leader's pose is larger than STILL
FACING = 0.05  # [rad] smaller heading errors of a stationary robot are not corrected
BRAKING = 0.5  # share of the wheels' limit; on the tightest arc SUMMIT-XL's outer wheels brake 1.7 times as hard


class _StationaryTimer:
    """Timer of a leader's standstill."""

    def __init__(self) -> None:
        self._pose: Pose2 | None = None
        self._since = 0.0

    @property
    def since(self) -> float:
        """Time from which the leader is stationary [s]."""
        return self._since

    def update(self, leader: Pose2 | None, now: float) -> float:
        """Add the leader's present pose; return the duration of its standstill [s]."""
        if leader is None or self._pose is None or leader.distance(self._pose) > MOVED:
            self._pose, self._since = leader, now
        return now - self._since


class _Search:
    """Search for a leader at an unknown position: one full turn, then a wait."""

    def __init__(self) -> None:
        self._last: Pose2 | None = None
        self._side = 1.0  # direction of the turn: toward the side where the leader was last seen
        self._searched = 0.0  # [s] time of the search, without that of reflexes

    def found(self, pose: Pose2, leader: Pose2) -> None:
        """Store the known pose of the leader and reset the search."""
        self._last, self._side, self._searched = leader, math.copysign(1.0, pose.bearing(leader)), 0.0

    def step(self, follow: FollowRobot, body: Body) -> Action:
        """Action of this period: continue the turn, or stop once a full turn is complete; raises ActionFailed."""
        searched, round_trip = self._searched, math.tau / follow.search_rate
        self._searched += body.period
        if searched > round_trip + follow.patience:
            last = "it was never seen"
            if self._last is not None:
                last = f"its last known position is x = {self._last.x:.2f} m, y = {self._last.y:.2f} m"
            evidence = f"'{follow.leader}' was not found in a search of {searched:.1f} s; {last}"
            raise ActionFailed(Reason.LOST_LEADER, evidence)
        rate = self._side * follow.search_rate if searched < round_trip else 0.0
        rate = free_turn(body, rate * body.period) / body.period
        return hold_twist(body, Twist2(0.0, rate), body.period)


class FollowRobot(PathAction):
    """Follow a peer along its predicted path at a maximum distance, with the trajectory follower.

    The robot moves like a trailer on a rope of length `distance`: it drives when the leader moves away and otherwise is
    stationary, so it does not cut corners more than a trailer does.

    When the leader comes nearer than `room`, for example because it turns round, or another peer comes near, the robot
    gives way. It uses only ground that is known to be free by the signals `room_ahead`, `room_behind` and
    `room_turned`. A robot without these signals waits. A robot with them turns on the spot toward its leader only where
    they report no obstacle for the corners of its hull. Nearer than `safety` the robot stops and leaves the situation
    to its reflexes.

    The pose of a leader out of view is predicted by Knowledge. Once it is unknown, the robot turns round once to
    search, then fails with LOST_LEADER.

    Attributes:
        leader: Peer of the world model.
        distance: Follow distance between the centres of the bases [m].
        room: Distance to keep from a leader that comes near, as far as free ground allows [m].
        safety: Distance from the leader below which the robot does not drive [m].
        cruise: Maximum speed [m/s]; a faster leader is lost.
        search_rate: Turn rate of the search [rad/s].
        patience: Waiting time after the search before the action fails [s].
        rest: Standstill of the leader after which the action succeeds [s]; never by default.
        heading: Yaw except when giving way: `along` the path, `keep`, an angle such as `90 deg`, or `look_at PLACE`.
        height: Height to fly at [m]; no change by default.

    Raises:
        InputError: safety, room and distance do not ascend.
    """

    leader: str
    distance: PositiveMetres = 1.2
    room: PositiveMetres = 1.0
    safety: PositiveMetres = 0.8
    cruise: PositiveMetresPerSecond = 0.6
    search_rate: PositiveRadiansPerSecond = 1.0
    patience: PositiveSeconds = 2.0
    rest: Annotated[Seconds, Bounds(0.0, above=True, infinite=True)] = math.inf
    heading: str = ALONG
    height: Height = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        self._stationary, self._search = _StationaryTimer(), _Search()
        if not self.safety < self.room < self.distance:
            found = f"{self.safety:g}, {self.room:g} and {self.distance:g} m"
            raise InputError(Fault(f"safety, room and distance of FollowRobot must ascend, found {found}."))

    def resume(self, cut_off: Action) -> None:
        super().resume(cut_off)
        if isinstance(cut_off, FollowRobot) and cut_off.leader == self.leader:
            self._stationary, self._search = cut_off._stationary, cut_off._search

    def awaits(self) -> str:
        if math.isinf(self.rest):
            return ""
        moved = f"it last moved at {self._stationary.since:.1f} s"
        return f"until its leader {self.leader} has been stationary for {self.rest:g} s ({moved})"

    def decompose(self, body: Body) -> Iterator[Action]:
        world, graph = body.knowledge.world, body.knowledge.graph
        if self.leader not in world.peers():
            hint = did_you_mean(self.leader, world.peers(), "The world")
            raise ActionFailed(Reason.NO_GOAL, f"no other robot is named '{self.leader}'. {hint}")
        graph.relate(body.knowledge.agent, "follows", self.leader, distance=self.distance, safety=self.safety)
        try:
            yield from self._follow(body)
        finally:
            graph.unrelate(body.knowledge.agent, "follows", self.leader)

    def _follow(self, body: Body) -> Iterator[Action]:
        drive, world = self.path_drive(body, self.cruise), body.knowledge.world
        give_way, course = self._give_way(body), Course()
        while True:
            now = body.clock.now()
            pose, leader = drive.pose(), world.predicted(self.leader, now)
            if self._stationary.update(leader, now) >= self.rest:
                return
            if pose is None:
                yield drive.brake()
                continue
            if leader is None:
                drive.brake()  # so that the next follower step starts from the measured wheel speeds
                yield self._search.step(self, body)
                continue
            self._search.found(pose, leader)
            course.note(now, leader)
            reference = None
            if pose.distance(leader) >= self.safety:
                reference = self._reference(body, drive, pose, give_way, course)
            yield drive.brake() if reference is None else drive.follow(pose, reference)

    def _give_way(self, body: Body) -> GiveWay:
        """Planner for giving way, for the hull of this robot; a hull of unknown size is a point."""
        hull = body.knowledge.graph.attributes(body.knowledge.agent)
        return GiveWay(
            length=self.distance,
            room=self.room,
            half=(0.5 * (hull.get("length") or 0.0), 0.5 * (hull.get("width") or 0.0)),
            speed=self.cruise,
            braking=BRAKING * body.locomotion.acceleration_limit,
            times=np.linspace(0.0, AHEAD, round(AHEAD / STEP) + 1),
            leader_times=np.linspace(0.0, AFAR, round(AFAR / STEP) + 1),
        )

    def _reference(
        self, body: Body, drive: PathDrive, pose: Pose2, give_way: GiveWay, course: Course
    ) -> Reference | None:
        """Reference of this period; None if it leads nowhere."""
        world, times = body.knowledge.world, body.clock.now() + give_way.times
        least = START if drive.stationary() else STILL
        names = [self.leader, *(name for name in world.peers() if name != self.leader)]
        motions = {name: motion for name in names if (motion := world.motion_of(name)) is not None}
        if self.leader not in motions:  # removed just now by another thread
            return None
        since = np.array([[t] for t, _, _ in motions.values()])
        leader, *others = along([motion[1:] for motion in motions.values()], times - since)
        path = trailer_path(pose, leader, self.distance, self.cruise * STEP, others, give_way.keep_off)
        first = _first(path, pose, least)
        if not self._heading.along and not give_way.needed(path, leader, others):
            turned = drive.turned(np.tile(path[0], (len(path), 1)) if first is None else path, give_way.times)
            faces = first is None and abs(turned[-1, 2] - pose.yaw) <= FACING
            return None if faces else TimedReference(times, turned, body.clock.now)
        # Within the follow distance the robot turns only if its leader has left the view ahead.
        turn = pose.bearing(Pose2(*leader[0].tolist())) if first is None else wrap_angle(first[2] - pose.yaw)
        tight = abs(turn) > TURN_FIRST and not (may_turn(body) and free_turn(body, turn) == turn)
        if tight or give_way.needed(path, leader, others):
            leading = course.ahead(motions[self.leader][2], give_way.leader_times)
            path = give_way.best(pose, leading, others, Room.known(body))
            first = _first(path, pose, least)
            turn = 0.0 if first is None else wrap_angle(first[2] - pose.yaw)
        if abs(turn) > TURN_FIRST:
            return TurnReference(
                wrap_angle(pose.yaw + free_turn(body, turn)), pose.x, pose.y, icr_offset=body.locomotion.icr_offset
            )
        return None if first is None else TimedReference(times, path, body.clock.now)


def _first(path: Array, pose: Pose2, least: float) -> Sequence[float] | None:
    """First pose of a path (k, 3) that is farther than `least` [m] from the robot; None if there is none."""
    rows: list[list[float]] = path.tolist()
    return next((row for row in rows if math.hypot(row[0] - pose.x, row[1] - pose.y) > least), None)
