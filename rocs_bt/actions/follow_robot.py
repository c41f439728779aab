"""FollowRobot: drive after another robot at a distance (paper, 6.5)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from ..action import Action, ActionFailed, Body, MacroAction, Reason
from ..control.arcs import along
from ..control.drive import Array
from ..control.reference import Reference, TimedReference, TurnReference
from ..errors import Fault, InputError, did_you_mean
from ..geometry import Pose2, Twist2, wrap_angle
from ..units import (
    Bounds,
    PositiveMetres,
    PositiveMetresPerSecond,
    PositiveRadiansPerSecond,
    PositiveSeconds,
    Seconds,
)
from .course import Course
from .following import TURN_FIRST, PathDrive
from .give_way import GiveWay, pulled
from .room import Room, free_turn, may_turn
from .set_wheel_speed import SetWheelSpeed

STEP = 0.1  # [s] between the places of the way to follow
AHEAD = 2.5  # [s] that the way covers: the follower's horizon and the wheels' lag
AFAR = 5.0  # [s] that it looks ahead at its leader where it must give way
MOVED = 0.2  # [m] A leader that went so far does not stand.
STILL = 0.02  # [m] A way that leads no farther is none: the wheels would be asked to creep.
START = 0.08  # [m] The same for a robot that stands: what it knows of its leader is not as sure as that.
BRAKING = 0.5  # of what the wheels may: on the tightest bend SUMMIT-XL's outer ones brake 1.7 times as hard as it.


class _Stand:
    """For how long a leader has stood."""

    def __init__(self) -> None:
        self._place: Pose2 | None = None
        self._since = 0.0

    def look(self, leader: Pose2 | None, now: float) -> float:
        """Note where it is now, and tell for how long it has stood [s]."""
        if leader is None or self._place is None or leader.distance(self._place) > MOVED:
            self._place, self._since = leader, now
        return now - self._since


class _Search:
    """Looking round for a leader that nobody knows the place of: one turn, then patience."""

    def __init__(self) -> None:
        self._last: Pose2 | None = None
        self._side = 1.0  # to which to turn, where it was seen last
        self._searched = 0.0  # [s]; while a reflex has the wheels it does not search

    def found(self, pose: Pose2, leader: Pose2) -> None:
        """The leader's place is known."""
        self._last, self._side, self._searched = leader, math.copysign(1.0, pose.bearing(leader)), 0.0

    def step(self, asked: FollowRobot, body: Body) -> Action:
        """This period's turn, or standstill once it has looked everywhere.

        Raises:
            ActionFailed: LOST_LEADER, when that was to no avail.
        """
        searched, round_trip = self._searched, math.tau / asked.search_rate
        self._searched += body.period
        if searched > round_trip + asked.patience:
            last = "it was never seen"
            if self._last is not None:
                last = f"it was last taken to be at x = {self._last.x:.2f} m, y = {self._last.y:.2f} m"
            evidence = f"'{asked.leader}' was not found in {searched:.1f} s of looking round; {last}"
            raise ActionFailed(Reason.LOST_LEADER, evidence)
        rate = self._side * asked.search_rate if searched < round_trip else 0.0
        rate = free_turn(body, rate * body.period) / body.period
        speeds = body.drive.wheel_speeds(Twist2(0.0, rate))
        return SetWheelSpeed(speeds=speeds.tolist(), duration=body.period)


@dataclass(kw_only=True, eq=False)
class FollowRobot(MacroAction):
    """Follow a peer as if a string tied the robot to it, with the follower, on the peer's predicted way.

    A leader that goes away pulls, and otherwise the robot stands: so it cuts corners no more than a trailer does. Where
    the leader comes nearer than `room`, as when it turns round, or another peer comes near, it gives way: over ground
    that is known to be free, which the signals `room_ahead`, `room_behind` and `room_turned` tell; a robot without them
    waits, and one with them turns after its leader on the spot only where they say that nothing is in its corners' way.
    Nearer than `safety` it stands still altogether, and what happens is the reflexes' matter. A leader that is out of
    view is where Knowledge predicts it; once nobody knows where it is the robot looks round once, and then fails with
    LOST_LEADER.

    Attributes:
        leader: A peer of the world model.
        distance: At which to follow, between the centres of the bases [m].
        room: What to leave to a leader that comes near, as far as there is a way off [m].
        safety: Distance from its leader within which it does not drive [m].
        cruise: Fastest speed [m/s]; only a leader that is slower can be kept up with.
        search_rate: How fast to look round [rad/s].
        patience: How long to wait for a leader, after having looked round, before giving up [s].
        rest: Done when the leader has stood for so long [s]; never by default.

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
    _stand: _Stand = field(init=False, repr=False, default_factory=_Stand)
    _search: _Search = field(init=False, repr=False, default_factory=_Search)

    def __post_init__(self) -> None:
        if not self.safety < self.room < self.distance:
            found = f"{self.safety:g}, {self.room:g} and {self.distance:g} m"
            raise InputError(Fault(f"safety, room and distance of FollowRobot must ascend, found {found}."))

    def resume(self, cut_off: Action) -> None:
        if isinstance(cut_off, FollowRobot) and cut_off.leader == self.leader:
            self._stand, self._search = cut_off._stand, cut_off._search

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
        drive, world = PathDrive(body, self.cruise), body.knowledge.world
        give_way, course = self._give_way(body), Course()
        while True:
            now = body.clock.now()
            pose, leader = drive.pose(), world.predicted(self.leader, now)
            if self._stand.look(leader, now) >= self.rest:
                return
            if pose is None:
                yield drive.brake()
                continue
            if leader is None:
                drive.brake()  # whoever follows next must ask how fast the wheels turn
                yield self._search.step(self, body)
                continue
            self._search.found(pose, leader)
            course.note(now, leader)
            reference = None
            if pose.distance(leader) >= self.safety:
                reference = self._reference(body, pose, give_way, course, START if drive.standing() else STILL)
            yield drive.brake() if reference is None else drive.follow(pose, reference)

    def _give_way(self, body: Body) -> GiveWay:
        """What it does for this robot; one that does not know its hull is a point."""
        hull = body.knowledge.graph.attributes(body.knowledge.agent)
        return GiveWay(
            length=self.distance,
            room=self.room,
            half=(0.5 * (hull.get("length") or 0.0), 0.5 * (hull.get("width") or 0.0)),
            speed=self.cruise,
            braking=BRAKING * body.drive.max_wheel_acceleration,
            times=np.linspace(0.0, AHEAD, round(AHEAD / STEP) + 1),
            afar=np.linspace(0.0, AFAR, round(AFAR / STEP) + 1),
        )

    def _reference(self, body: Body, pose: Pose2, give_way: GiveWay, course: Course, least: float) -> Reference | None:
        """Where the robot goes next; None where that is not even `least` away [m]."""
        world, times = body.knowledge.world, body.clock.now() + give_way.times
        names = [self.leader, *(name for name in world.peers() if name != self.leader)]
        motions = {name: motion for name in names if (motion := world.motion_of(name)) is not None}
        if self.leader not in motions:  # given up just now, by another thread
            return None
        since = np.array([[t] for t, _, _ in motions.values()])
        leader, *others = along([motion[1:] for motion in motions.values()], times - since)
        way = pulled(pose, leader, self.distance, self.cruise * STEP, others, give_way.keep_off)
        first = _first(way, pose, least)
        # A slack string does not turn the robot, unless its leader has gone out of sight of what looks ahead.
        turn = pose.bearing(Pose2(*leader[0].tolist())) if first is None else wrap_angle(first[2] - pose.yaw)
        tight = abs(turn) > TURN_FIRST and not (may_turn(body) and free_turn(body, turn) == turn)
        if tight or give_way.needed(way, leader, others):
            leading = course.ahead(motions[self.leader][2], give_way.afar)
            way = give_way.best(pose, leading, others, Room.known(body))
            first = _first(way, pose, least)
            turn = 0.0 if first is None else wrap_angle(first[2] - pose.yaw)
        if abs(turn) > TURN_FIRST:
            return TurnReference(wrap_angle(pose.yaw + free_turn(body, turn)), pose.x, pose.y, pivot=body.drive.pivot)
        return None if first is None else TimedReference(times, way, body.clock.now)


def _first(way: Array, pose: Pose2, least: float) -> Sequence[float] | None:
    """The first pose of a way (k, 3) that is more than `least` away [m]."""
    rows: list[list[float]] = way.tolist()
    return next((row for row in rows if math.hypot(row[0] - pose.x, row[1] - pose.y) > least), None)
