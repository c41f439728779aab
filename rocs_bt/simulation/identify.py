"""System identification of a robot's drive on an infinite plane, for its robot.toml.

A skid-steer robot is described by an ideal differential drive that turns as the robot does. The effective wheel
separation is that of this drive. The ICR offset is the position of its axle, on which the instantaneous centre of
rotation is (Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..agent import robot_locomotion
from ..catalog import AgentSpec, Catalog, RateSpec, RobotSpec, ScenarioSpec
from ..control.locomotion import Locomotion
from ..errors import Fault, InputError
from ..event import NullSink
from ..geometry import Pose2, wrap_angle
from .simulated_world import build_world

WORLD = "plane"
"""Name of the world used for identification, from the catalog."""

_NAME = "robot"
_TURNS = (
    (-0.05, 0.05),
    (-0.1, 0.1),
    (-0.2, 0.2),
    (0.4, -0.4),
    (0.1, 0.2),
    (0.2, 0.15),
)  # factors of the maximum wheel speed
_CURVES = ((0.15, 0.3), (0.3, 0.15), (0.4, 0.55), (0.55, 0.4))  # factors of the maximum wheel speed
_SPEEDS = (0.2, 0.35, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)  # [m/s] initial speeds of the braking tests
_SETTLE, _WATCH = 2.0, 2.0  # [s] settling time of a motion; duration of its measurement
_STEADY = 1e-3  # [m/s] maximum change of a steady speed in 0.5 s
_STOPPED = 0.005  # [m/s] maximum speed that counts as stopped
_TIMEOUT = 20.0  # [s]


@dataclass(frozen=True)
class Braking:
    """Braking test from a steady speed to standstill.

    Attributes:
        speed: Initial speed [m/s].
        distance: Distance from the stop command to standstill [m].
        time: Time from the stop command to standstill [s].
    """

    speed: float
    distance: float
    time: float


@dataclass(frozen=True)
class Identified:
    """Identified parameters of a robot's drive.

    Attributes:
        robot: Name of the robot.
        effective_wheel_separation: Effective wheel separation, from true wheel linear speeds [m].
        wheel_separation_error: Maximum error of the turn rate that the effective wheel separation predicts for a
            single turn, relative to that turn rate.
        slowest_turn: Minimum ratio of the wheels' speed difference in a turn to the commanded one; load causes the
            loss.
        icr_offset: Distance ahead of the base at which the robot does not skid sideways in a forward curve [m]. The
            distance is smaller at lower speed, smaller still when turning in place, and nearly 0 in reverse.
        wheel_lag: Total delay and lag of the wheels, on a ramp at the drive's maximum acceleration [s].
        top_speed: Forward speed with all wheels at their maximum speed [m/s].
        brake_delay: Delay of the braking model: stopping distance = v * delay + v^2 / (2 deceleration) [s].
        deceleration: Deceleration of the braking model [m/s2].
        misfit: Maximum error of the braking model, relative to the measured stopping distance.
        braking: Braking tests.
    """

    robot: str
    effective_wheel_separation: float
    wheel_separation_error: float
    slowest_turn: float
    icr_offset: float
    wheel_lag: float
    top_speed: float
    brake_delay: float
    deceleration: float
    misfit: float
    braking: tuple[Braking, ...]


def identify(robot: RobotSpec, catalog: Catalog) -> Identified:
    """Drive a robot's model on a plane, without blocks and rules, and identify its parameters.

    Args:
        robot: Specification of the robot; its drive must turn by the speed difference of two sides.
        catalog: Source of the world and of the robot's drivers.

    Raises:
        InputError: The robot has no model, or its drive does not turn by the speed difference of two sides.
    """
    locomotion = robot_locomotion(robot.locomotion)
    if locomotion.twist_from_q.shape[1] != 2:
        message = f"a '{locomotion.kind}' locomotion has no effective wheel separation."
        raise InputError(
            Fault(message, robot.file, hint="Only drives that turn by the speed difference of two sides have one.")
        )

    def rig() -> _TestRig:
        return _TestRig(robot, locomotion, catalog)

    separation, error, share = _turns(rig, locomotion)
    top = rig().steady(locomotion.max_speed.min())
    braking = tuple(_brake(rig(), speed) for speed in _SPEEDS if speed <= 0.98 * top)
    delay, deceleration, misfit = _fit(braking)
    icr_offset, lag = _icr_offset(rig, locomotion), _lag(rig(), locomotion)
    return Identified(robot.name, separation, error, share, icr_offset, lag, top, delay, deceleration, misfit, braking)


class _TestRig:
    """A single robot at rest on the plane, with its usual devices."""

    def __init__(self, robot: RobotSpec, locomotion: Locomotion, catalog: Catalog) -> None:
        agent = AgentSpec(_NAME, robot.name, "", (), Pose2(0.0, 0.0), Pose2(0.0, 0.0))
        file, rate = catalog.find("world", WORLD).path, RateSpec()
        scenario = ScenarioSpec(
            "identify",
            file,
            "",
            WORLD,
            _TIMEOUT,
            end_on_collision=False,
            rate=rate,
            places=(),
            agents=(agent,),
            actors=(),
        )
        simulated = build_world(scenario, catalog, 1, NullSink())
        self.world = simulated.world
        self.period = rate.control_rate.period
        self._every = rate.control_rate.every
        self._locomotion = locomotion
        self._wheels = simulated.actuators[_NAME][robot.locomotion.actuator]
        self._measured_speeds = simulated.wheels[_NAME]
        self.turned = 0.0

    @property
    def pose(self) -> Pose2:
        """True pose of the robot, world frame."""
        return self.world.pose(_NAME)

    @property
    def speed(self) -> float:
        """True forward speed of the robot [m/s]."""
        return self.world.twist(_NAME).forward

    def sides(self) -> tuple[float, float]:
        """True wheel linear speeds of the left and right side [m/s]."""
        left, right = self._locomotion.coordinates(np.array(self._measured_speeds())).tolist()
        return left, right

    def step(self, left: float, right: float) -> None:
        """Drive for one control period at these wheel linear speeds of the sides [m/s]."""
        before = self.pose.yaw
        self._wheels.command((self._locomotion.values_from_q @ np.array([left, right])).tolist())
        self.world.advance(self._every)
        self.turned += wrap_angle(self.pose.yaw - before)

    def hold(self, left: float, right: float, duration: float) -> None:
        """Command the wheel linear speeds of the left and the right side [m/s] for a duration [s]."""
        for _ in range(round(duration / self.period)):
            self.step(left, right)

    def steady(self, speed: float) -> float:
        """Drive straight until the speed is steady; returns the speed [m/s]."""
        last = math.nan
        for _ in range(round(_TIMEOUT / 0.5)):
            self.hold(speed, speed, 0.5)
            if abs(self.speed - last) <= _STEADY:
                break
            last = self.speed
        return self.speed


def _turns(rig: Callable[[], _TestRig], locomotion: Locomotion) -> tuple[float, float, float]:
    """Measure turns: effective wheel separation [m], `wheel_separation_error` and `slowest_turn` of `Identified`."""
    differences, rates, shares = [], [], []
    for left, right in np.array(_TURNS) * locomotion.max_speed.min():
        robot = rig()
        robot.hold(left, right, _SETTLE)
        robot.turned = 0.0
        robot.hold(left, right, _WATCH)
        sides = robot.sides()
        differences.append(sides[1] - sides[0])
        rates.append(robot.turned / _WATCH)
        shares.append(differences[-1] / (right - left))
    wide, fast = np.array(differences), np.array(rates)
    separation = float(wide @ fast / (fast @ fast))
    return separation, float(np.max(np.abs(wide / separation / fast - 1.0))), float(min(shares))


def _icr_offset(rig: Callable[[], _TestRig], locomotion: Locomotion) -> float:
    """Distance ahead of the base at which the lateral speed in steady curves is smallest [m], by least squares."""
    turns, skids = [], []
    for left, right in np.array(_CURVES) * locomotion.max_speed.min():
        robot = rig()
        robot.hold(left, right, _SETTLE)
        for _ in range(round(_WATCH / robot.period)):
            robot.step(left, right)
            twist = robot.world.twist(_NAME)
            turns.append(twist.turn)
            skids.append(twist.left)
    turned = np.array(turns)
    return float(-(turned @ skids) / (turned @ turned))


def _lag(robot: _TestRig, locomotion: Locomotion) -> float:
    """Measure the time by which the wheels lag behind a speed ramp to half their maximum speed [s]."""
    top, speed, commanded = 0.5 * locomotion.max_speed.min(), 0.0, 0.0
    for _ in range(round((top / locomotion.max_acceleration.min() + _SETTLE) / robot.period)):
        speed = min(speed + locomotion.max_acceleration.min() * robot.period, top)
        robot.step(speed, speed)
        commanded += speed * robot.period
    sag = robot.speed / top  # load reduces the effective wheel radius a little, which is no lag
    return float((commanded - Pose2(0.0, 0.0).distance(robot.pose) / sag) / top)


def _brake(robot: _TestRig, speed: float) -> Braking:
    begun, start = robot.steady(speed), robot.pose
    time = robot.world.clock.now()
    while abs(robot.speed) > _STOPPED and robot.world.clock.now() - time < _TIMEOUT:
        robot.step(0.0, 0.0)
    return Braking(begun, start.distance(robot.pose), robot.world.clock.now() - time)


def _fit(braking: Sequence[Braking]) -> tuple[float, float, float]:
    """Fit distance / speed = delay + speed / (2 deceleration): delay [s], deceleration [m/s2], relative misfit."""
    v, d = np.array([b.speed for b in braking]), np.array([b.distance for b in braking])
    (delay, slope), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(v), v]), d / v, rcond=None)
    delay = max(float(delay), 0.0)
    return delay, float(0.5 / slope), float(np.max(np.abs((delay + slope * v) * v / d - 1.0)))
