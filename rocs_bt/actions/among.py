"""Among: drives along a route among movers, as long as there are any near the robot."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..base.geometry import Pose2
from ..control.locomotion import Array
from ..control.reference import TURN_RATE, TimedReference
from ..control.space_time import PARTS, Manners, MotionLimits, SpaceTime, TimedPlan
from ..control.way_field import WayField
from ..event import PathPlanned
from ..interfaces.action import Action, Body
from ..knowledge import Movers
from .known_ground import known_speed
from .path_drive import PathDrive

NEAR = 7.0
"""Distance within which movers count [m]."""

REACH = 8.0
"""Half the side of the square around the robot in which it plans [m]."""

PLAN_EVERY, FIELD_EVERY = 0.1, 0.3
"""Times between two plans, and between two updates of the way [s]."""

SLOW = 0.25
"""Speed below which a mover counts as standing, so that the way leads around it [m/s]."""

OWN = 0.1
"""Distance from a mover within which points of the map count as its own [m]."""

BACK = 0.8
"""Greatest speed in reverse [m/s]."""

ACCELERATION, DECELERATION, TURN_ACCELERATION = 2.0, 3.5, 5.0
"""Greatest planned rates of change of speed [m/s2] and turn rate [rad/s2]."""


class Among:
    """Motion of a robot among the movers of its Knowledge, while there are any near it.

    Args:
        body: Robot.
        drive: Follower of its paths.
        cruise: Forward speed [m/s].
        manners: Behaviour among people.
    """

    def __init__(self, body: Body, drive: PathDrive, cruise: float, manners: Manners) -> None:
        self._body, self._drive = body, drive
        self._hull = body.knowledge.robot.hull
        self._search: SpaceTime | None = None
        if self._hull is not None:
            limits = body.locomotion
            self._search = SpaceTime(
                self._hull,
                MotionLimits(
                    cruise=min(cruise, limits.axis_limits("vx").max_speed),
                    back=min(BACK, limits.axis_limits("vx").max_speed),
                    turn_rate=min(TURN_RATE, limits.turn_limit),
                    acceleration=min(ACCELERATION, limits.acceleration_limit),
                    deceleration=min(DECELERATION, limits.acceleration_limit),
                    turn_acceleration=min(TURN_ACCELERATION, limits.turn_acceleration_limit),
                    top=limits.speed_limit,
                    arm=limits.arm if limits.wheeled else 0.0,
                ),
                manners,
            )
        self._field: WayField | None = None
        self._renewed = self._planned = -math.inf
        self._reference: TimedReference | None = None
        self._route: Sequence[Sequence[float]] = ()

    def near(self, pose: Pose2) -> bool:
        """Whether something moves near the robot, so that `step` drives it."""
        world = self._body.knowledge.world
        tracked = self._search is not None and world.movers is not None and world.occupancy is not None
        if not tracked or not _near(world.movers, pose):
            self._field = self._reference = None
            return False
        return True

    def step(self, pose: Pose2, route: Sequence[Sequence[float]]) -> Action:
        """Action for this period, in which something is `near`.

        Args:
            pose: Pose of the robot, world frame.
            route: Route from the robot to the goal, world frame [m].
        """
        movers = self._body.knowledge.world.movers
        assert movers is not None
        now, late = self._body.clock.now(), 0.5 * self._body.period
        reference = self._reference
        # At usual control rates, no period computes two of a new route, a plan and the way.
        wait = PLAN_EVERY if route is self._route else 1.5 * PLAN_EVERY
        due = reference is None or now - self._planned >= wait - late
        self._route = route
        old = now - self._renewed + late
        busy = due and self._body.period < PLAN_EVERY - late
        if self._field is None or (old >= FIELD_EVERY and not busy) or old >= 2.0 * FIELD_EVERY:
            self._renew(pose, np.array([point[:2] for point in route]), movers)
            self._renewed = now
        if reference is None or due:
            self._planned, plan = now, self._plan(pose, movers)
            reference = self._reference = TimedReference(plan.times, plan.poses, self._body.clock.now)
            self._body.note(PathPlanned, points=tuple(map(tuple, plan.poses[::PARTS, :2].tolist())))
        return self._drive.follow(pose, reference)

    def _renew(self, pose: Pose2, route: Array, movers: Movers) -> None:
        grid, here = self._body.knowledge.world.occupancy, np.array(pose[:2])
        assert grid is not None
        assert self._hull is not None
        points = grid.points(tuple(here - REACH), tuple(here + REACH), moving=False)
        # Echoes of a mover from before it counted as one may still be in the map.
        away = np.hypot(*(points[:, None] - movers.mean[:, :2]).transpose(2, 0, 1)) - movers.radius
        self._field = WayField(here, REACH, points[(away > OWN).all(axis=1)], self._hull)
        slow = np.hypot(movers.mean[:, 2], movers.mean[:, 3]) < SLOW
        standing = np.column_stack([movers.mean[:, :2], movers.radius])[slow]
        ahead = route[int(np.hypot(*(route - here).T).argmin()) :]  # a kept route has its driven part, too
        self._field.lead(np.vstack([here, ahead]), standing)

    def _plan(self, pose: Pose2, movers: Movers) -> TimedPlan:
        assert self._search is not None
        assert self._field is not None
        start, twist, delay = self._drive.start(pose)
        begin = self._body.clock.now() + delay
        prediction = movers.predict(self._search.times(begin), self._field)
        back = -known_speed(self._body, -BACK)
        return self._search.plan(begin, start, twist, self._field, prediction, back)


def _near(movers: Movers | None, pose: Pose2) -> bool:
    if movers is None:
        return False
    return bool((np.hypot(movers.mean[:, 0] - pose.x, movers.mean[:, 1] - pose.y) < NEAR).any())
