"""System identification of a robot's motion on an infinite plane, for its robot.toml.

Each axis of the body twist is measured by commands to the robot's own actuator: reached speed, lag behind a ramp, and
stopping distances.

A skid-steer robot is described by an ideal differential drive that turns as the robot does. The effective wheel
separation is that of this drive. The ICR offset is the position of its axle, on which the instantaneous centre of
rotation is (Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2, Twist3, wrap_angle
from ..catalog import AgentSpec, CachingCatalog, Catalog, RateSpec, RobotSpec, ScenarioSpec
from ..control.locomotion import AXES, Locomotion
from ..declare import Value
from ..event import NullSink
from .identified_file import AxisFigures, WheelFigures
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
_BRAKINGS = (0.2, 0.35, 0.5, 0.65, 0.8, 0.95)  # initial speeds of the braking tests, factors of the speed limit
_SETTLE, _WATCH = 2.0, 2.0  # [s] settling time of a motion; duration of its measurement
_WINDOW = 0.5  # [s] duration over which a steady speed is averaged
_GAIT_WINDOW = 6.0  # [s] the same for a body with legs, which sways: a whole number of the steps of most gaits
_MISFIT = 0.3  # relative error of the braking model from which on the model is not used
_STEADY = 2e-3  # maximum change of a steady speed from window to window, relative to the command
_STOPPED = 0.005  # [m/s, rad/s] maximum speed that counts as stopped
_MOVES = 0.05  # minimum speed of a body that moves, relative to the command
_FALLEN = 1.0  # [rad] roll or pitch of a body that has fallen
_TIMEOUT = 20.0  # [s]
_CLIMB = 1.5  # [m] height over the start of the tests of a flying body

Array = npt.NDArray[np.float64]


class BrakingTest(Value):
    """Braking test from a steady speed to standstill.

    Attributes:
        speed: Initial speed [m/s, rad/s].
        distance: Distance from the stop command to standstill [m, rad].
        time: Time from the stop command to standstill [s].
    """

    speed: float
    distance: float
    time: float


class IdentifiedAxis(AxisFigures):
    """Identified motion along one axis, with its braking tests."""

    misfit: float  # maximum error of the braking model, relative to the measured distance
    braking: tuple[BrakingTest, ...]


class IdentifiedWheels(WheelFigures):
    """Identified drive that turns by the speed difference of two sides.

    Attributes:
        wheel_separation_error: Maximum error of the turn rate that the effective wheel separation predicts for a
            single turn, relative to that turn rate.
        slowest_turn: Minimum ratio of the wheels' speed difference in a turn to the commanded one; load causes the
            loss.
    """

    wheel_separation_error: float
    slowest_turn: float


class Identified(Value):
    """Identified parameters of a robot's motion.

    Attributes:
        robot: Name of the robot.
        axes: Motion by axis of the twist, such as `vx`: those that the robot can command. A vertical motion is measured
            upwards.
        wheels: Parameters of a drive that turns by the speed difference of two sides; None for other locomotions.
    """

    robot: str
    axes: Mapping[str, IdentifiedAxis]
    wheels: IdentifiedWheels | None


def identify(robot: RobotSpec, catalog: Catalog) -> Identified:
    """Move a robot's model on a plane, without blocks and rules, and identify its parameters.

    Raises:
        InputError: The robot has no model, begins inside the floor, does not move along one of its axes, or falls over.
    """
    locomotion = robot.locomotion
    cached = CachingCatalog(catalog.project, code=catalog.code)  # compiles the model once

    def rig() -> _TestRig:
        return _TestRig(robot, locomotion, cached)

    axes = {axis: _axis(rig, locomotion, axis) for axis in locomotion.axes}
    sided = locomotion.wheeled and locomotion.twist_from_q.shape[1] == 2
    return Identified(robot=robot.name, axes=axes, wheels=_wheels(rig, locomotion) if sided else None)


class _TestRig:
    """A single robot at rest on the plane, with its usual devices; a flying robot hovers.

    Attributes:
        travel: Distance moved since the start by axis, body frame [m, rad].
    """

    def __init__(self, robot: RobotSpec, locomotion: Locomotion, catalog: Catalog) -> None:
        agent = AgentSpec(name=_NAME, robot=str(robot.file), mission="", pose=Pose2(0.0, 0.0))
        rate = RateSpec()
        scenario = ScenarioSpec(name="identify", file=robot.file, world=WORLD, duration=_TIMEOUT, agents=(agent,))
        simulated = build_world(scenario, catalog, 1, NullSink())
        self.world = simulated.world
        self.period = rate.control_rate.period
        self.travel = dict.fromkeys(AXES, 0.0)
        self._every = rate.control_rate.every
        self._robot = robot
        self._locomotion = locomotion
        self._window = _GAIT_WINDOW if locomotion.kind == "legged" else _WINDOW
        self._motion = simulated.actuators[_NAME][robot.motion.actuator]
        self._commanded = list(locomotion.rest)
        self._measured_speeds = simulated.wheels.get(_NAME, lambda: self._commanded)
        if "vz" in locomotion.axes:
            self._take_off()

    def speed(self, axis: str) -> float:
        """True speed along an axis, body frame [m/s, rad/s]."""
        twist = self.world.twist(_NAME)
        up = float(self.world.data.qvel[self.world.body(_NAME).v + 2])
        return {"vx": twist.forward, "vy": twist.left, "vz": up, "wz": twist.turn}[axis]

    def sides(self) -> tuple[float, float]:
        """True wheel linear speeds of the left and right side [m/s]."""
        left, right = self._locomotion.coordinates(np.array(self._measured_speeds())).tolist()
        return left, right

    def along(self, axis: str, speed: float) -> Array:
        """Command (m,) of a speed along one axis [m/s, rad/s]."""
        return self._locomotion.command(Twist3(*(float(name == axis) for name in AXES))) * speed

    def step(self, command: Array) -> None:
        """Move for one control period with a command (m,); raises InputError."""
        x, y, z, _, _, yaw = self.world.pose3(_NAME)
        self._commanded = command.tolist()
        self._motion.command(self._commanded)
        self.world.advance(self._every)
        pose, solid = self.world.pose(_NAME), self.world.pose3(_NAME)
        if max(abs(solid.roll), abs(solid.pitch)) > _FALLEN:
            found = ", ".join(f"{v:.3g}" for v in self._commanded)
            hint = "Lower max_speed or max_acceleration in [locomotion], or correct its driver."
            raise InputError(Fault(f"the robot fell over with the command {found}.", self._robot.file, hint=hint))
        c, s, dx, dy = math.cos(yaw), math.sin(yaw), pose.x - x, pose.y - y
        moved = (c * dx + s * dy, c * dy - s * dx, solid.z - z, wrap_angle(pose.yaw - yaw))
        for axis, distance in zip(AXES, moved, strict=True):
            self.travel[axis] += distance

    def hold(self, command: Array, duration: float) -> None:
        """Move with a command (m,) for a duration [s]."""
        for _ in range(round(duration / self.period)):
            self.step(command)

    def hold_sides(self, left: float, right: float, duration: float) -> None:
        """Command the wheel linear speeds of the left and the right side [m/s] for a duration [s]."""
        self.hold(self._locomotion.values_from_q @ np.array([left, right]), duration)

    def reach(self, axis: str, speed: float, acceleration: float = math.inf) -> tuple[float, float, float]:
        """Accelerate along an axis by a ramp, and hold the speed until it is steady; raises InputError.

        Args:
            axis: Axis of the twist.
            speed: Commanded speed [m/s, rad/s].
            acceleration: Acceleration of the ramp [m/s2, rad/s2]; at most the maximum one.

        Returns:
            Steady speed [m/s, rad/s], lag behind the ramp [s], and distance moved, without the sway [m, rad].
        """
        change = min(self._locomotion.axis_limits(axis).max_acceleration, acceleration) * self.period
        start, given, commanded = self.travel[axis], 0.0, 0.0
        while given < speed:
            given = min(given + change, speed)
            self.step(self.along(axis, given))
            commanded += given * self.period
        last, steady, before = math.nan, math.nan, self.travel[axis] - start
        window = self._window
        for _ in range(round(_TIMEOUT / window)):
            moments = []
            for _ in range(round(window / self.period)):
                self.step(self.along(axis, speed))
                commanded += speed * self.period
                moments.append((commanded / speed, self.travel[axis] - start))
            last, steady = steady, (moments[-1][1] - before) / window
            before = moments[-1][1]
            if abs(steady - last) <= _STEADY * speed:
                break
        if not steady > _MOVES * speed:
            message = f"the robot does not move along {axis}: commanded {speed:.3g}, reached {steady:.3g}."
            hint = f"Correct the order and signs of the commands of its actuator '{self._motion.name}', or its driver."
            if axis == "wz" and abs(steady) <= _MOVES * speed:
                hint = f"It does not turn on the spot, which the actions of rocs_bt need. {hint}"
            raise InputError(Fault(message, self._robot.file, hint=hint))
        # Load reduces the steady speed a little, which is no lag. The mean leaves out the sway of a body with legs.
        lag = float(np.mean([time - distance / steady for time, distance in moments]))
        return steady, lag, start + steady * (commanded / speed - lag)

    def brake(self, axis: str, start: float) -> tuple[float, float]:
        """Command not to move until the robot is stationary; returns distance from start [m, rad] and time [s]."""
        time, rest = 0.0, np.array(self._locomotion.rest)
        while self.speed(axis) > _STOPPED and time < _TIMEOUT:
            self.step(rest)
            time += self.period
        farthest = self.travel[axis]
        for _ in range(round(self._window / self.period)):  # a swaying body may stop for a moment only
            self.step(rest)
            farthest = max(farthest, self.travel[axis])
        return farthest - start, time

    def _take_off(self) -> None:
        up = self.along("vz", self._locomotion.axis_limits("vz").max_speed)
        for _ in range(round(_TIMEOUT / self.period)):
            if self.travel["vz"] >= _CLIMB:
                break
            self.step(up)
        self.brake("vz", self.travel["vz"])


def _axis(rig: Callable[[], _TestRig], locomotion: Locomotion, axis: str) -> IdentifiedAxis:
    """Measure the motion along one axis."""
    limit, braking = locomotion.axis_limits(axis).max_speed, []
    top, _, _ = rig().reach(axis, limit)
    robot = rig()
    for factor in _BRAKINGS:
        speed, _, start = robot.reach(axis, factor * limit)
        distance, time = robot.brake(axis, start)
        braking.append(BrakingTest(speed=speed, distance=distance, time=time))
    latency, deceleration, misfit = _fit(braking)
    # Wheels that brake at their grip do not accelerate faster: their slip on the ramp is no lag.
    grip = deceleration if locomotion.wheeled and misfit <= _MISFIT else math.inf
    _, lag, _ = rig().reach(axis, 0.5 * limit, grip)
    found: dict[str, Any] = {"max_speed": top, "lag": lag, "misfit": misfit, "braking": tuple(braking)}
    if misfit > _MISFIT:
        longest = max(b.distance for b in braking) * (top / braking[-1].speed) ** 2  # from the speed of the last test
        return IdentifiedAxis(**found, stop_distance=longest)
    stop_distance = top * latency + top * top / (2.0 * deceleration)
    return IdentifiedAxis(**found, latency=latency, deceleration=deceleration, stop_distance=stop_distance)


def _wheels(rig: Callable[[], _TestRig], locomotion: Locomotion) -> IdentifiedWheels:
    """Measure a drive with two sides in turns and curves."""
    differences, rates, shares = [], [], []
    for left, right in np.array(_TURNS) * locomotion.max_speed.min():
        robot = rig()
        robot.hold_sides(left, right, _SETTLE)
        turned = robot.travel["wz"]
        robot.hold_sides(left, right, _WATCH)
        sides = robot.sides()
        differences.append(sides[1] - sides[0])
        rates.append((robot.travel["wz"] - turned) / _WATCH)
        shares.append(differences[-1] / (right - left))
    wide, fast = np.array(differences), np.array(rates)
    separation = float(wide @ fast / (fast @ fast))
    error = float(np.max(np.abs(wide / separation / fast - 1.0)))
    return IdentifiedWheels(
        effective_wheel_separation=separation,
        icr_offset=_icr_offset(rig, locomotion),
        wheel_separation_error=error,
        slowest_turn=float(min(shares)),
    )


def _icr_offset(rig: Callable[[], _TestRig], locomotion: Locomotion) -> float:
    """Distance ahead of the base at which the lateral speed in steady curves is smallest [m], by least squares."""
    turns, skids = [], []
    for left, right in np.array(_CURVES) * locomotion.max_speed.min():
        robot = rig()
        robot.hold_sides(left, right, _SETTLE)
        for _ in range(round(_WATCH / robot.period)):
            robot.hold_sides(left, right, robot.period)
            turns.append(robot.speed("wz"))
            skids.append(robot.speed("vy"))
    turned = np.array(turns)
    return float(-(turned @ skids) / (turned @ turned))


def _fit(braking: Sequence[BrakingTest]) -> tuple[float, float, float]:
    """Fit distance / speed = latency + speed / (2 deceleration): latency [s], deceleration, relative misfit."""
    v, d = np.array([b.speed for b in braking]), np.array([b.distance for b in braking])
    (latency, slope), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(v), v]), d / v, rcond=None)
    latency, slope = max(float(latency), 0.0), max(float(slope), 1e-4)  # a body may stop after the same time always
    return latency, 0.5 / slope, float(np.max(np.abs((latency + slope * v) * v / d - 1.0)))
