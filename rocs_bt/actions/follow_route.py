"""FollowRoute: drive along a route that may be replaced on the way, slower near obstacles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from ..base.errors import InputError
from ..base.geometry import Pose2
from ..base.units import LENGTH, NOT_NEGATIVE, Metres, PositiveMetres, PositiveMetresPerSecond, PositiveSeconds
from ..control.locomotion import Array
from ..control.path import Path
from ..control.space_time import SIDES, Manners
from ..interfaces.action import Action, ActionFailed, Body, Reason
from .among import Among
from .heading import ALONG
from .known_ground import known_speed
from .path_action import Height, PathAction
from .pose import GoalAction, goal_pose, goal_tolerance

if TYPE_CHECKING:
    from ..knowledge import Knowledge

LATERAL = 0.5
"""Maximum lateral acceleration in curves [m/s2]; above it the wheels skid and the robot leaves the path."""

TURN_FIRST = 0.6
"""Heading error beyond which the robot turns on the spot [rad]."""

BEHIND = 1.9
"""Heading error above which a route is driven backward if the robot has no room to turn [rad]."""

ROLLING = 0.25
"""Speed above which the robot brakes before it turns on the spot [m/s]."""

SWING = 0.03
"""Minimum gap of the hull to obstacles during a partial turn on the spot [m]."""

TURNING = 0.06
"""Minimum gap around the hull for a full turn on the spot [m]."""

GRAIN = 5
"""Number of path samples per evaluation of the clearance, which is every 5 cm."""

SWEEP = 9
"""Number of yaws at which the clearance during a turn on the spot is checked."""

RENEW = 0.2
"""Minimum time between two updates of the speeds after changes of the map [s]."""

PROGRESS = 0.1
"""Displacement within `patience` below which the robot is stuck, in space for a desired height [m]."""


class FollowRoute(GoalAction, PathAction):
    """Drive along a route to a goal with the follower, as fast as the clearance allows.

    The route may be replaced at any time (`points` is live), so the robot keeps driving while a new one is planned. The
    clearance is the gap between the hull and the obstacles of the robot's own map along the route. The speed grows from
    `creep` without clearance to `cruise` at a clearance of `ease`.

    While something moves near a robot that tracks it, the robot plans its motion in space and time around the route: it
    waits, yields, backs away or passes. See docs/navigation.md.

    A route that begins behind the robot is driven backward until there is room to turn, as far as the ground behind is
    seen to be free or was driven. The action fails as STUCK if a smaller turn on the spot would swing the hull into an
    obstacle. A robot with another heading than `along` does neither: it drives sideways or backward as the heading
    demands.

    Attributes:
        points: Route as (x, y) from the robot's position, world frame [m].
        goal: Node of the world model with a pose, at the end of the route.
        cruise: Speed on straight parts [m/s].
        creep: Speed without clearance [m/s].
        ease: Clearance at which the robot drives at `cruise` [m].
        tolerance: Distance from the goal at which it is reached, 0 for the goal's tolerance [m].
        passing: Whether the goal also counts as reached by a moving robot, which can stop within the tolerance.
        patience: Time without progress after which the action fails as STUCK [s].
        wait: The same while something moves near the robot [s].
        personal_space: Gap to what moves below which closeness costs time [m].
        pass_on: Side on which the robot prefers to pass others: `right`, `left` or `either`.
        heading: Yaw on the way: `along` the route, `keep`, an angle such as `90 deg`, or `look_at PLACE`.
            An angle holds on arrival, too, within 5 deg.
        height: Height to fly at [m], 0.15 m away from what `above` and `below` detect; no change by default.
    """

    live: ClassVar[tuple[str, ...]] = ("points",)

    points: Annotated[Sequence[Sequence[float]], LENGTH]
    goal: str
    cruise: PositiveMetresPerSecond = 1.0
    creep: PositiveMetresPerSecond = 0.2
    ease: Annotated[Metres, NOT_NEGATIVE] = 0.4
    tolerance: Annotated[Metres, NOT_NEGATIVE] = 0.0
    passing: bool = False
    patience: PositiveSeconds = 3.0
    wait: PositiveSeconds = 10.0
    personal_space: PositiveMetres = 0.35
    pass_on: str = "right"
    heading: str = ALONG
    height: Height = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        if wrong := _unknown_side(self.pass_on):
            raise InputError(f"{wrong}.")

    @classmethod
    def misfits(cls, parameters: Mapping[str, Any], knowledge: Knowledge) -> Iterator[tuple[str, str]]:
        yield from super().misfits(parameters, knowledge)
        if wrong := _unknown_side(parameters.get("pass_on", SIDES[0])):
            yield "pass_on", wrong

    def decompose(self, body: Body) -> Iterator[Action]:
        self._pursue(body)
        yield from self._drive_to_goal(body)  # if it fails, the goal stays: the mission plans another route to it
        self._release(body)

    def _drive_to_goal(self, body: Body) -> Iterator[Action]:
        drive, room = self.path_drive(body, self.cruise, LATERAL, TURN_FIRST), _Room(body)
        among = Among(body, drive, self.cruise, Manners(personal_space=self.personal_space, side=self.pass_on))
        driven: Sequence[Sequence[float]] | None = None
        anchor, since, free = None, body.clock.now(), body.clock.now()
        while True:
            pose, goal, now = drive.pose(), goal_pose(body, self.goal), body.clock.now()
            if pose is None:
                yield drive.brake()
                continue
            near = goal_tolerance(body, self.goal, self.tolerance)
            there = pose.distance(goal) <= near + body.locomotion.sway and drive.at_height(near)
            if there and (self.passing or (drive.faces(pose) and drive.stationary())):
                return
            rise, moving = drive.height_error(), among.near(pose)
            if moving:
                free = now
            if anchor is None or not math.hypot(pose.distance(anchor[0]), rise - anchor[1]) <= PROGRESS:
                anchor, since = (pose, rise), now
            # A wait among movers is no lack of progress once they are gone.
            elif now - (since if moving else max(since, free)) > (patience := self.wait if moving else self.patience):
                raise ActionFailed(Reason.STUCK, f"it moved less than {PROGRESS} m in {patience:g} s")
            # Among movers the yaw is that of the plan; at the goal the robot turns to its heading.
            if moving and not (there and not drive.faces(pose)):
                driven, drive.backward = None, False
                yield among.step(pose, self.points)
                continue
            if driven is not self.points:
                driven = self.points
                path = Path([list(p[:2]) for p in driven])
                drive.begin(path, self._speeds(room.along(path, drive.yaws(path))), self._end(body, path, goal))
                if abs(drive.heading_error) > BEHIND and not room.can_turn(pose):
                    drive.backward = True
            if drive.backward and (room.can_turn(pose) or not known_speed(body, -self.creep)):
                drive.backward = False
            if room.changed():
                drive.limit(self._speeds(room.along(path, drive.yaws(path))), self._end(body, path, goal))
            turning = abs(drive.heading_error) > TURN_FIRST and not drive.backward
            # A robot that still drives forward would swing out in the turn.
            if turning and abs(body.knowledge.robot.speed()) > ROLLING:
                yield drive.brake()
                continue
            if turning and room.turn_blocked(pose, drive.heading_error):
                raise ActionFailed(Reason.STUCK, f"no room to turn by {drive.heading_error:.2f} rad")
            yield drive.step(pose)

    def _speeds(self, room: Array) -> Array:
        """Speeds allowed by clearances (n,) [m], shape (n,) [m/s]."""
        share = np.clip(room / self.ease, 0.0, 1.0) if self.ease > 0.0 else np.ones_like(room)
        speeds: Array = np.minimum(self.creep, self.cruise) * (1.0 - share) + self.cruise * share
        return speeds

    def _end(self, body: Body, path: Path, goal: Pose2) -> float:
        """Speed limit at the end of the path [m/s]: the robot that passes the goal can stop within the tolerance."""
        near = goal_tolerance(body, self.goal, self.tolerance)
        if not self.passing or np.hypot(*(path.position(path.length) - goal[:2])) > near:
            return 0.0
        return min(self.cruise, math.sqrt(2.0 * near * body.locomotion.axis_limits("vx").max_acceleration))


def _unknown_side(side: str) -> str:
    """Reason why a text is no side; empty if it is one."""
    return "" if side in SIDES else f"pass_on must be {', '.join(SIDES[:-1])} or {SIDES[-1]}, found '{side}'"


class _Room:
    """Clearance of the hull along a path and in turns on the spot, from the robot's occupancy grid."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self._footprint = body.knowledge.robot.hull
        self._icr_offset = body.locomotion.icr_offset
        self._grid = body.knowledge.world.occupancy
        self._revision, self._updated = -1, -np.inf

    def can_turn(self, pose: Pose2) -> bool:
        """Whether the hull has room for a full turn on the spot."""
        if self._grid is None or self._footprint is None:
            return True
        reach = (
            float(np.hypot(0.5 * self._footprint.length + abs(self._icr_offset), 0.5 * self._footprint.width)) + TURNING
        )
        x, y = pose.transform(self._icr_offset, 0.0)
        window = self._grid.window((x - reach, y - reach), (x + reach, y + reach))
        return bool((np.hypot(*(window.points() - (x, y)).T) > reach).all())

    def turn_blocked(self, pose: Pose2, turn: float) -> bool:
        """Whether a turn on the spot by an angle [rad] would bring the hull nearer than `SWING` to an obstacle."""
        if self._grid is None or self._footprint is None or self.can_turn(pose):
            return False
        reach = 2.0 * self._footprint.outer
        window = self._grid.window((pose.x - reach, pose.y - reach), (pose.x + reach, pose.y + reach))
        points, yaws = window.points(), pose.yaw + np.linspace(0.0, turn, SWEEP)
        # A skid drive turns on the spot about a point between its base and its centre of rotation in curves.
        for icr_offset in (0.0, self._icr_offset):
            middle = pose.transform(icr_offset, 0.0)
            poses = np.column_stack([middle - icr_offset * np.column_stack([np.cos(yaws), np.sin(yaws)]), yaws])
            now, *gaps = self._footprint.clearance(poses, points).tolist()
            if min(gaps) < min(SWING, now):
                return True
        return False

    def changed(self) -> bool:
        """Whether the map has changed and the last update is at least `RENEW` ago."""
        late = self._body.clock.now() - self._updated >= RENEW - 0.5 * self._body.period
        return late and self._grid is not None and self._grid.revision != self._revision

    def along(self, path: Path, yaws: Array | None = None) -> Array:
        """Gap from the hull to the nearest obstacle at each sample of a path, shape (n,) [m]; +inf without a map.

        Args:
            path: Path.
            yaws: Yaw at each sample, shape (n,) [rad]; None for the tangent.
        """
        if self._grid is None or self._footprint is None:
            return np.full(len(path.samples), np.inf)
        poses = path.samples[::GRAIN, :3]
        if yaws is not None:
            poses = np.column_stack([poses[:, :2], yaws[::GRAIN]])
        reach = self._footprint.outer + 1.0
        window = self._grid.window(tuple(poses[:, :2].min(axis=0) - reach), tuple(poses[:, :2].max(axis=0) + reach))
        self._revision, self._updated = window.revision, self._body.clock.now()
        gaps = self._footprint.clearance(poses, window.points())
        return np.asarray(np.interp(np.arange(len(path.samples)), np.arange(len(gaps)) * GRAIN, gaps))
