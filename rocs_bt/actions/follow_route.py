"""FollowRoute: drive along a way that may change meanwhile, slower where it is tight."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np

from ..action import Action, ActionFailed, Body, MacroAction, Reason
from ..control.drive import Array
from ..control.footprint import Footprint
from ..control.path import Path
from ..geometry import Pose2
from ..units import LENGTH, NOT_NEGATIVE, Metres, PositiveMetres, PositiveMetresPerSecond, PositiveSeconds
from .following import PathDrive
from .go_to import goal_pose

if TYPE_CHECKING:
    from ..knowledge import Knowledge

LATERAL = 0.5
"""Side acceleration in curves [m/s2]: wheels that skid keep no line at more."""

TURN_FIRST = 0.6
"""Heading error beyond which the robot turns on the spot [rad]."""

BEHIND = 1.9
"""A way that begins so far off the robot's heading is driven backward where there is no room to turn [rad]."""

ROLLING = 0.25
"""A robot that is faster does not turn on the spot [m/s]."""

SWING = 0.03
"""Nobody turns on the spot where that would bring the hull so near to something [m]: it is left for elsewhere first."""

TURNING = 0.06
"""The gap that a hull needs all around to turn on the spot [m]."""

GRAIN = 5
"""The clearance is asked at each so manieth sample of a path: every 5 cm."""

SWEEP = 9
"""In so many places a turn on the spot is looked at."""

RENEW = 0.2
"""So often, at most, the speeds are fitted to a map that has changed [s]."""

PROGRESS = 0.1
"""A robot that moves less than so far within its patience is stuck [m]."""


@dataclass(kw_only=True, eq=False)
class FollowRoute(MacroAction):
    """Drive along a way to a goal with the follower, as fast as the room beside the robot allows.

    The way may be replaced at any time while it is driven (`points` is live): planning takes its time elsewhere, and
    the robot goes on along what it has. The room is that between its hull and what stands in its own map, at each
    place of the way; `cruise` needs `ease` of it, and at none the robot creeps. A way that leads back is driven
    backward until there is room to turn; where a lesser turn on the spot would swing the hull into something it fails.

    Attributes:
        points: The way as (x, y) in the world frame, from where the robot is [m].
        goal: A node of the world model that has a pose, where the way leads in the end.
        cruise: Speed on the straight [m/s].
        creep: Speed with no room at all [m/s].
        ease: The room at which it cruises [m].
        tolerance: Distance from the goal at which it is reached [m].
        passing: Whether it is reached in passing, and not only standing.
        patience: For how long the robot may get nowhere before it fails as STUCK [s].
    """

    live: ClassVar[tuple[str, ...]] = ("points",)

    points: Annotated[Sequence[Sequence[float]], LENGTH]
    goal: str
    cruise: PositiveMetresPerSecond = 1.0
    creep: PositiveMetresPerSecond = 0.2
    ease: Annotated[Metres, NOT_NEGATIVE] = 0.4
    tolerance: PositiveMetres = 0.1
    passing: bool = False
    patience: PositiveSeconds = 3.0

    def decompose(self, body: Body) -> Iterator[Action]:
        world = body.knowledge.world
        if self.goal in world.goals():
            world.pursue(self.goal)
        yield from self._drive(body)
        if world.pursued() == self.goal:
            world.pursue(None)

    def remaining(self, knowledge: Knowledge) -> float:
        goal = knowledge.world.pose_of(self.goal)
        return float("nan") if goal is None else knowledge.robot.pose().distance(goal)

    def _drive(self, body: Body) -> Iterator[Action]:
        drive, room = PathDrive(body, self.cruise, LATERAL, TURN_FIRST), _Room(body)
        driven: Sequence[Sequence[float]] | None = None
        anchor, since = None, body.clock.now()
        while True:
            pose, goal, now = drive.pose(), goal_pose(body, self.goal), body.clock.now()
            if pose is None:
                yield drive.brake()
                continue
            if pose.distance(goal) <= self.tolerance and (self.passing or drive.standing()):
                return
            if anchor is None or pose.distance(anchor) > PROGRESS:
                anchor, since = pose, now
            elif now - since > self.patience:
                raise ActionFailed(Reason.STUCK, f"it moved less than {PROGRESS} m in {self.patience:g} s")
            if driven is not self.points:
                driven = self.points
                path = Path([list(p[:2]) for p in driven])
                drive.begin(path, self._speeds(room.along(path)), self._end(path, goal))
                if abs(drive.heading_error) > BEHIND and not room.to_turn(pose):
                    drive.backward = True
            if drive.backward and room.to_turn(pose):
                drive.backward = False
            if room.changed():
                drive.limit(self._speeds(room.along(path)), self._end(path, goal))
            turning = abs(drive.heading_error) > TURN_FIRST and not drive.backward
            # Who turns on the spot stands first, or it would swing out.
            if turning and abs(body.knowledge.robot.speed()) > ROLLING:
                yield drive.brake()
                continue
            if turning and room.in_the_way(pose, drive.heading_error):
                raise ActionFailed(Reason.STUCK, f"there is no room to turn by {drive.heading_error:.2f} rad")
            yield drive.step(pose)

    def _speeds(self, room: Array) -> Array:
        """(n,) What the room allows [m/s]."""
        share = np.clip(room / self.ease, 0.0, 1.0) if self.ease > 0.0 else np.ones_like(room)
        speeds: Array = np.minimum(self.creep, self.cruise) * (1.0 - share) + self.cruise * share
        return speeds

    def _end(self, path: Path, goal: Pose2) -> float:
        """How fast it may be at the path's end [m/s]."""
        at_goal = bool(np.hypot(*(path.position(path.length) - goal[:2])) <= self.tolerance)
        return self.cruise if self.passing and at_goal else 0.0


class _Room:
    """How much room there is beside the hull along a path, by the robot's own map.

    Args:
        body: The robot, whose length and width stand in Knowledge.
    """

    def __init__(self, body: Body) -> None:
        self._body = body
        known = body.knowledge.graph.attributes(body.knowledge.agent)
        length, width = known.get("length"), known.get("width")
        self._footprint = Footprint(length, width) if length and width else None
        self._pivot = body.drive.pivot
        self._grid = body.knowledge.world.occupancy
        self._revision, self._asked = -1, -np.inf

    def to_turn(self, pose: Pose2) -> bool:
        """Whether the hull can turn on the spot, all the way round."""
        if self._grid is None or self._footprint is None:
            return True
        reach = float(np.hypot(0.5 * self._footprint.length + abs(self._pivot), 0.5 * self._footprint.width)) + TURNING
        x, y = pose.transform(self._pivot, 0.0)
        window = self._grid.window((x - reach, y - reach), (x + reach, y + reach))
        return bool((np.hypot(*(window.points() - (x, y)).T) > reach).all())

    def in_the_way(self, pose: Pose2, turn: float) -> bool:
        """Whether something is, or nearly, when the hull turns on the spot by an angle [rad]."""
        if self._grid is None or self._footprint is None or self.to_turn(pose):
            return False
        reach = 2.0 * self._footprint.outer
        window = self._grid.window((pose.x - reach, pose.y - reach), (pose.x + reach, pose.y + reach))
        points, yaws = window.points(), pose.yaw + np.linspace(0.0, turn, SWEEP)
        # On the spot a skid drive turns about a place between its base and the pivot of its curves.
        for pivot in (0.0, self._pivot):
            middle = pose.transform(pivot, 0.0)
            poses = np.column_stack([middle - pivot * np.column_stack([np.cos(yaws), np.sin(yaws)]), yaws])
            now, *gaps = self._footprint.clearance(poses, points).tolist()
            if min(gaps) < min(SWING, now):
                return True
        return False

    def changed(self) -> bool:
        """Whether it is worth asking anew."""
        late = self._body.clock.now() - self._asked >= RENEW - 0.5 * self._body.period
        return late and self._grid is not None and self._grid.revision != self._revision

    def along(self, path: Path) -> Array:
        """(n,) The hull's gap to the nearest thing at each of a path's samples [m]; +inf where no map tells."""
        if self._grid is None or self._footprint is None:
            return np.full(len(path.samples), np.inf)
        poses = path.samples[::GRAIN, :3]
        reach = self._footprint.outer + 1.0
        window = self._grid.window(tuple(poses[:, :2].min(axis=0) - reach), tuple(poses[:, :2].max(axis=0) + reach))
        self._revision, self._asked = window.revision, self._body.clock.now()
        gaps = self._footprint.clearance(poses, window.points())
        return np.asarray(np.interp(np.arange(len(path.samples)), np.arange(len(gaps)) * GRAIN, gaps))
