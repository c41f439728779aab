"""Flat world: a scene of line segments and circles without physics, in which robots take commands immediately.

world = FlatWorld(clock, segments=[((2, -1), (2, 1))])
robot = FlatRobot(world, differential_drive(...), Pose2(0, 0, 0), {"front": Pose2(0.2, 0, 0)}, {"l": 0.1, "r": 0.1})
sonar = RangeCone(sites=("front",), range=(0.1, 1.0)).bind("sonar", world, robot.name)
wheels = Velocity(motors=("l", "r"), wheel_radius=0.1).bind("wheels", world, robot.name)
wheels.command([0.3, 0.3])
world.advance(0.05)
"""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np

from ...base.clock import Clock
from ...base.errors import InputError, unknown
from ...base.geometry import Pose2, Pose3, Twist3, along_arc
from ...control.locomotion import Locomotion
from ...interfaces.safety_gate import SafetyGate
from .scene import Array, Rays

Point: TypeAlias = tuple[float, float]


class FlatWorld:
    """World of robots on a plane, a `Scene`.

    Attributes:
        robots: Robots of the world by name; a `FlatRobot` adds itself.

    Args:
        clock: Clock of the world; the caller of `advance` must also advance the clock.
        segments: Walls, each as its two end points, world frame [m].
        circles: Round obstacles, each as centre, world frame [m], and radius [m].
        places: Positions of places by name, world frame; batteries are charged at some of them.
    """

    def __init__(
        self,
        clock: Clock,
        segments: Sequence[tuple[Point, Point]] = (),
        circles: Sequence[tuple[Point, float]] = (),
        places: Mapping[str, Pose2] | None = None,
    ) -> None:
        self.clock, self.lock = clock, threading.RLock()
        self.segments = list(segments)
        self.circles = list(circles)
        self.places = dict(places or {})
        self.robots: dict[str, FlatRobot] = {}

    @property
    def stamp(self) -> float:
        return self.clock.now()

    def advance(self, duration: float) -> None:
        """Move every robot for a duration [s]. Robots do not collide, and only a robot_sensor detects them."""
        for robot in self.robots.values():
            robot.advance(duration)

    def ray(self, x: float, y: float, yaw: float) -> float:
        """Distance along a ray to the nearest obstacle [m]; +inf without a hit.

        Args:
            x: Origin, world frame [m].
            y: Origin, world frame [m].
            yaw: Direction, world frame [rad].
        """
        c, s = math.cos(yaw), math.sin(yaw)
        hits = [_hit_segment(x, y, c, s, *seg) for seg in self.segments]
        hits += [_hit_circle(x, y, c, s, *circle) for circle in self.circles]
        return min(hits, default=math.inf)

    def pose(self, robot: str) -> Pose2:
        return self.robots[robot].pose

    def pose3(self, robot: str) -> Pose3:
        x, y, yaw = self.pose(robot)
        return Pose3(x, y, 0.0, yaw=yaw)

    def twist3(self, robot: str) -> Twist3:
        return self.robots[robot].locomotion.twist3(self.robots[robot].motion)

    def sees(self, robot: str, other: str, height: float) -> bool:
        here, there = self.pose(robot), self.pose(other)
        away = there.x - here.x, there.y - here.y
        return self.ray(here.x, here.y, math.atan2(away[1], away[0])) >= math.hypot(*away)

    def direction(self, robot: str, site: str, axis: Literal["x", "z"]) -> tuple[float, float, float, float]:
        return (*self.robots[robot].mounts[site], 0.0)

    def beams(self, robot: str, sensor: str, sites: Sequence[str], angles: Sequence[tuple[float, float]]) -> Rays:
        return self._rays(robot, sensor, sites, [left for left, _ in angles])

    def scan(self, robot: str, site: str, bearings: Sequence[float], reach: float, sweep: float) -> Rays:
        cast = self._rays(robot, site, [site], bearings)
        return lambda: cast()[0]

    def motors(self, robot: str, names: Sequence[str], *limits: object) -> tuple[FlatRobot, list[int], list[float]]:
        """Handle of motors; the limits are those of electronics, which robots without dynamics do not have."""
        body = self.robots[robot]
        if missing := [name for name in names if name not in body.motors]:
            raise InputError(*(unknown("motor", name, body.motors, f"The robot '{robot}'") for name in missing))
        order = list(body.motors)
        return body, [order.index(name) for name in names], [body.motors[name] for name in names]

    def drive(self, motors: Any, speeds: Sequence[float]) -> None:
        body, order, factors = motors
        motion = list(body.motion)
        for i, speed, factor in zip(order, speeds, factors, strict=True):
            motion[i] = speed * factor
        body.motion = motion

    def motor_speeds(self, motors: Any) -> list[float]:
        body, order, factors = motors
        return [body.motion[i] / factor for i, factor in zip(order, factors, strict=True)]

    def motor_angles(self, motors: Any) -> list[float]:
        body, order, factors = motors
        return [body.wheel_travel[i] / factor for i, factor in zip(order, factors, strict=True)]

    def _rays(self, robot: str, sensor: str, sites: Sequence[str], bearings: Sequence[float]) -> Rays:
        body = self.robots[robot]
        if missing := [site for site in sites if site not in body.mounts]:
            raise InputError(*(unknown(f"mount for sensor '{sensor}'", s, body.mounts, "The robot") for s in missing))

        def cast() -> Array:
            origins = [body.pose.compose(body.mounts[site]) for site in sites]
            return np.array([[self.ray(x, y, yaw + left) for left in bearings] for x, y, yaw in origins])

        return cast


class FlatRobot:
    """Robot without dynamics: the body takes a command immediately, and moves by the kinematics exactly.

    Attributes:
        motion: Values of the last command.
        wheel_travel: Travel of each wheel since the start [m].
        gates: Safety gates of the actuators; their watchdogs are checked when the world advances.

    Args:
        world: World of the robot.
        locomotion: Locomotion of the robot.
        pose: Start pose, world frame.
        mounts: Poses of the sites of range sensors, body frame, by name.
        motors: Signed wheel radius [m] of the motor of each wheel by name, in the order of the locomotion's wheels.
        name: Name of the robot; by default that of the first free number, as R1.
    """

    def __init__(
        self,
        world: FlatWorld,
        locomotion: Locomotion,
        pose: Pose2,
        mounts: Mapping[str, Pose2] | None = None,
        motors: Mapping[str, float] | None = None,
        *,
        name: str = "",
    ) -> None:
        self.world, self.name = world, name or f"R{len(world.robots) + 1}"
        self.locomotion = locomotion
        self.pose = pose
        self.mounts = dict(mounts or {})
        self.motors = dict(motors or {})
        self.motion = list(locomotion.rest)
        self.wheel_travel = [0.0] * len(locomotion.wheels)
        self.gates: list[SafetyGate] = []
        world.robots[self.name] = self

    def advance(self, duration: float) -> None:
        """Move the robot for a duration [s], along an exact arc."""
        for gate in self.gates:
            gate.check()
        self.pose = along_arc(self.pose, self.locomotion.twist(np.array(self.motion)), duration)
        travelled = zip(self.wheel_travel, self.motion, strict=False)
        self.wheel_travel = [travel + speed * duration for travel, speed in travelled]


def _hit_segment(x: float, y: float, c: float, s: float, a: Point, b: Point) -> float:
    ex, ey = b[0] - a[0], b[1] - a[1]
    cross = c * ey - s * ex
    if cross == 0.0:
        return math.inf
    dx, dy = a[0] - x, a[1] - y
    along, share = (dx * ey - dy * ex) / cross, (dx * s - dy * c) / cross
    return along if along >= 0.0 and 0.0 <= share <= 1.0 else math.inf


def _hit_circle(x: float, y: float, c: float, s: float, centre: Point, radius: float) -> float:
    dx, dy = centre[0] - x, centre[1] - y
    along = dx * c + dy * s
    across = dx * dx + dy * dy - along * along
    if across > radius * radius:
        return math.inf
    half = math.sqrt(radius * radius - across)
    if along - half >= 0.0:
        return along - half
    return 0.0 if along + half >= 0.0 else math.inf
