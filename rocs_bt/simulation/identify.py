"""What a robot does when its wheels are told something: measured on an endless plane, for its robot.toml.

The effective track is the track of the differential drive that turns as the robot does, and the pivot is the place of
its axle (Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..agent import robot_drive
from ..catalog import AgentSpec, Catalog, RateSpec, RobotSpec, ScenarioSpec
from ..control.drive import Drive
from ..errors import Fault, InputError
from ..event import NullSink
from ..geometry import Pose2, wrap_angle
from .simulated_world import build_world

WORLD = "plane"
"""The world that it happens in, which the catalog finds."""

_NAME = "robot"
_TURNS = ((-0.05, 0.05), (-0.1, 0.1), (-0.2, 0.2), (0.4, -0.4), (0.1, 0.2), (0.2, 0.15))  # of the greatest rim speed
_CURVES = ((0.15, 0.3), (0.3, 0.15), (0.4, 0.55), (0.55, 0.4))  # of the greatest rim speed
_SPEEDS = (0.2, 0.35, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)  # [m/s] to brake from
_SETTLE, _WATCH = 2.0, 2.0  # [s] until a motion is steady; for how long it is measured
_STEADY = 1e-3  # [m/s] by which a steady speed changes in half a second, at most
_STANDING = 0.005  # [m/s]
_PATIENCE = 20.0  # [s]


@dataclass(frozen=True)
class Braking:
    """From a steady speed [m/s] to standstill: how far [m] and how long [s] after the command."""

    speed: float
    distance: float
    time: float


@dataclass(frozen=True)
class Identified:
    """What was measured of a robot.

    Attributes:
        robot: Its name.
        effective_track: Of the differential drive that turns as it does, from true rim speeds [m].
        track_error: By how much a single turn strays from that, at most; a share of its turn rate.
        slowest_turn: The least share of the commanded turn that the wheels made; what is missing they lost to the load.
        pivot: How far ahead of the base the place lies that does not skid sideways in a curve driven forward [m]; it is
            nearer when slower, nearer still on the spot, and backward nearly the base.
        wheel_lag: Delay and lag of its wheels together, on a ramp at the drive's greatest acceleration [s].
        top_speed: Straight ahead with all wheels at the greatest rim speed [m/s].
        brake_delay, deceleration: Such that it stops within v * delay + v^2 / (2 deceleration) [s], [m/s2].
        misfit: By how much that strays from what was measured, at most; a share of the distance.
        braking: From a few speeds.
    """

    robot: str
    effective_track: float
    track_error: float
    slowest_turn: float
    pivot: float
    wheel_lag: float
    top_speed: float
    brake_delay: float
    deceleration: float
    misfit: float
    braking: tuple[Braking, ...]


def identify(robot: RobotSpec, catalog: Catalog) -> Identified:
    """Drive a robot's model on a plane and measure it; its blocks and rules are not there.

    Args:
        robot: The robot; its drive must turn by the difference of two sides.
        catalog: Where the plane, and its own drivers, are found.

    Raises:
        InputError: It has no model, or its drive has no sides.
    """
    drive = robot_drive(robot.drive)
    if drive.twist_from_q.shape[1] != 2:
        message = f"a '{drive.name}' drive has no effective track."
        raise InputError(Fault(message, robot.file, hint="Only drives that turn by the difference of two sides have."))

    def bench() -> _Bench:
        return _Bench(robot, drive, catalog)

    track, error, share = _turns(bench, drive)
    top = bench().steady(drive.max_wheel_speed)
    braking = tuple(_brake(bench(), speed) for speed in _SPEEDS if speed <= 0.98 * top)
    delay, deceleration, misfit = _fit(braking)
    pivot, lag = _pivot(bench, drive), _lag(bench(), drive)
    return Identified(robot.name, track, error, share, pivot, lag, top, delay, deceleration, misfit, braking)


class _Bench:
    """One robot alone on the plane, at rest, with the devices that it has in any run."""

    def __init__(self, robot: RobotSpec, drive: Drive, catalog: Catalog) -> None:
        agent = AgentSpec(_NAME, robot.name, "", (), Pose2(0.0, 0.0), Pose2(0.0, 0.0))
        file, rate = catalog.find("world", WORLD).path, RateSpec()
        scenario = ScenarioSpec(
            "identify",
            file,
            "",
            WORLD,
            _PATIENCE,
            end_on_collision=False,
            rate=rate,
            places=(),
            agents=(agent,),
            movers=(),
        )
        simulated = build_world(scenario, catalog, 1, NullSink())
        self.world = simulated.world
        self.period = rate.control_rate.period
        self._every = rate.control_rate.every
        self._drive = drive
        self._wheels = simulated.actuators[_NAME][robot.drive.actuator]
        self._rims = simulated.wheels[_NAME]
        self.turned = 0.0

    @property
    def pose(self) -> Pose2:
        """Where it truly is."""
        return self.world.pose(_NAME)

    @property
    def speed(self) -> float:
        """How fast it truly goes forward [m/s]."""
        return self.world.twist(_NAME).forward

    def sides(self) -> tuple[float, float]:
        """The true rim speeds of the left and the right side [m/s]."""
        left, right = self._drive.coordinates(np.array(self._rims())).tolist()
        return left, right

    def step(self, left: float, right: float) -> None:
        """One control period with these rim speeds [m/s]."""
        before = self.pose.yaw
        self._wheels.command((self._drive.wheels_from_q @ np.array([left, right])).tolist())
        self.world.advance(self._every)
        self.turned += wrap_angle(self.pose.yaw - before)

    def hold(self, left: float, right: float, duration: float) -> None:
        """Many of them [s]."""
        for _ in range(round(duration / self.period)):
            self.step(left, right)

    def steady(self, speed: float) -> float:
        """Drive straight on until the speed stays; what it is then [m/s]."""
        last = math.nan
        for _ in range(round(_PATIENCE / 0.5)):
            self.hold(speed, speed, 0.5)
            if abs(self.speed - last) <= _STEADY:
                break
            last = self.speed
        return self.speed


def _turns(bench: Callable[[], _Bench], drive: Drive) -> tuple[float, float, float]:
    """Effective track [m], its greatest relative error over single turns, and the least share of a command made."""
    differences, rates, shares = [], [], []
    for left, right in np.array(_TURNS) * drive.max_wheel_speed:
        robot = bench()
        robot.hold(left, right, _SETTLE)
        robot.turned = 0.0
        robot.hold(left, right, _WATCH)
        sides = robot.sides()
        differences.append(sides[1] - sides[0])
        rates.append(robot.turned / _WATCH)
        shares.append(differences[-1] / (right - left))
    wide, fast = np.array(differences), np.array(rates)
    track = float(wide @ fast / (fast @ fast))
    return track, float(np.max(np.abs(wide / track / fast - 1.0))), float(min(shares))


def _pivot(bench: Callable[[], _Bench], drive: Drive) -> float:
    """How far ahead of the base the place lies that does not go sideways in steady curves, at best [m]."""
    turns, skids = [], []
    for left, right in np.array(_CURVES) * drive.max_wheel_speed:
        robot = bench()
        robot.hold(left, right, _SETTLE)
        for _ in range(round(_WATCH / robot.period)):
            robot.step(left, right)
            twist = robot.world.twist(_NAME)
            turns.append(twist.turn)
            skids.append(twist.left)
    turned = np.array(turns)
    return float(-(turned @ skids) / (turned @ turned))


def _lag(robot: _Bench, drive: Drive) -> float:
    """How much later than its command a rim gets anywhere [s], on a ramp up to half its greatest speed."""
    top, asked, told = 0.5 * drive.max_wheel_speed, 0.0, 0.0
    for _ in range(round((top / drive.max_wheel_acceleration + _SETTLE) / robot.period)):
        asked = min(asked + drive.max_wheel_acceleration * robot.period, top)
        robot.step(asked, asked)
        told += asked * robot.period
    sag = robot.speed / top  # a loaded wheel is a little smaller than its radius, which is no lag
    return (told - Pose2(0.0, 0.0).distance(robot.pose) / sag) / top


def _brake(robot: _Bench, speed: float) -> Braking:
    begun, start = robot.steady(speed), robot.pose
    time = robot.world.clock.now()
    while abs(robot.speed) > _STANDING and robot.world.clock.now() - time < _PATIENCE:
        robot.step(0.0, 0.0)
    return Braking(begun, start.distance(robot.pose), robot.world.clock.now() - time)


def _fit(braking: Sequence[Braking]) -> tuple[float, float, float]:
    """Delay [s], deceleration [m/s2] and relative misfit of distance / speed = delay + speed / (2 deceleration)."""
    v, d = np.array([b.speed for b in braking]), np.array([b.distance for b in braking])
    (delay, slope), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(v), v]), d / v, rcond=None)
    delay = max(float(delay), 0.0)
    return delay, float(0.5 / slope), float(np.max(np.abs((delay + slope * v) * v / d - 1.0)))
