"""Trajectory follower: one small quadratic program per control period, with fallbacks if the solver fails.

The follower computes the next wheel speeds from a reference and a pose in bounded time. Its commands are always within
the wheel limits. The last fallback is a braking ramp, never an exception or NaN.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, Literal, TypeAlias

import numpy as np

from ..errors import InputError
from ..geometry import Pose2, Twist2, wrap_angle
from .drive import Array, Drive
from .follower_qp import Layout, Weights, build
from .reference import Reference

Rung: TypeAlias = Literal["solved", "previous plan", "braking"]
SOLVED: Final = "solved"
PREVIOUS: Final = "previous plan"
BRAKING: Final = "braking"

_INSTANT = 1e-9  # [s] durations below this are rounding errors

FARTHEST = 1e6  # [m, rad] larger coordinates would overflow
TOLERANCE = 1.01  # a plan above this multiple of a limit counts as failed; a smaller excess is clipped at the end


@dataclass(frozen=True)
class FollowerSettings:
    """Settings of the follower.

    Attributes:
        blocks: Lengths of the move blocks, in stages of the prediction; their sum is the horizon.
        dt: Duration of a stage [s].
        weights: Weights of the cost.
        iterations: Maximum number of solver iterations per period.
        patience: Maximum number of consecutive periods that use the previous plan after failed solves.
        wheel_delay: Dead time between a command and the response of the wheels [s].
        wheel_lag: Time constant of the wheels' first-order response after the dead time [s].
        jump: Distance between the poses of two periods beyond which the plan is discarded, because the robot must have
            been carried [m].
    """

    blocks: tuple[int, ...] = (1, 1, 1, 2, 2, 3, 4, 6)
    dt: float = 0.1
    weights: Weights = field(default_factory=Weights)
    iterations: int = 200
    patience: int = 3
    wheel_delay: float = 0.0
    wheel_lag: float = 0.0
    jump: float = 0.5

    @property
    def late(self) -> float:
        """Steady-state lag of the wheel speeds behind a ramp command [s]: dead time plus time constant."""
        return self.wheel_delay + self.wheel_lag


@dataclass(frozen=True, eq=False)
class Command:
    """Command for the coming period, and its source.

    Attributes:
        wheel_speeds: Wheel linear speeds to command, shape (w,) [m/s].
        rung: Source of the command: `solved`, `previous plan` if the solver failed, or `braking` as the last fallback.
        cross_track: Cross-track error, left of the reference positive [m]; NaN if unknown.
        heading_error: Yaw minus the reference's [rad]; NaN if unknown.
        solve_time: Duration of this step by the injected timer [s]; NaN without a timer.
    """

    wheel_speeds: Array
    rung: Rung
    cross_track: float
    heading_error: float
    solve_time: float

    @property
    def ok(self) -> bool:
        """Whether the command comes from a fresh plan."""
        return self.rung == SOLVED


class Follower:
    """Trajectory follower of one drive.

    The follower assumes that the wheels have the speeds that it commanded last, which makes every quadratic program
    feasible. Pass `wheel_speeds` to `step` if something else, such as a reflex, has commanded the wheels since.

    Args:
        drive: Drive to command.
        settings: Settings; None for the default ones.
        timer: Timer such as `time.perf_counter`, for `Command.solve_time` only [s].
    """

    def __init__(
        self,
        drive: Drive,
        settings: FollowerSettings | None = None,
        timer: Callable[[], float] | None = None,
    ) -> None:
        self.drive = drive
        self.settings = settings or FollowerSettings()
        for name in ("wheel_delay", "wheel_lag"):
            if not 0.0 <= (value := getattr(self.settings, name)) < math.inf:
                raise InputError(f"{name} must be 0 s or more, found {value} s.")
        self._timer = timer
        self._layout = Layout(drive, self.settings.blocks, self.settings.dt)
        self._times = np.arange(1.0, self._layout.stages + 1.0) * self.settings.dt
        self._rows = np.vstack([self._layout.speed_rows, self._layout.acceleration_rows])
        self._shift, self._shift_period = np.eye(len(self.settings.blocks) + 1), math.nan
        self._program = _Program(self._layout, self.settings)
        self._rest = np.zeros(len(self.drive.wheels))
        self.reset()

    @cached_property
    def backward(self) -> Follower:
        """Follower for backward driving, in which a skid drive turns nearly about its base: no ICR offset."""
        return (
            self
            if self.drive.icr_offset == 0.0
            else Follower(self.drive.without_icr_offset, self.settings, self._timer)
        )

    def reset(self) -> None:
        """Reset plan, wheel speeds and history to those of a robot at rest."""
        self._wheels = self._rest
        self._twist = Twist2(0.0)
        self._plan: Array | None = None  # (blocks + 1, n) nodes of q; the first is the last command
        self._misses = 0
        self._pose: Pose2 | None = None
        self._sent: deque[tuple[float, Array]] = deque()  # commands within the dead time, the oldest first
        self._turning = self._rest  # (w,) modelled wheel speeds after the dead time [m/s]

    def step(self, pose: Pose2, wheel_speeds: Array | None, reference: Reference, period: float) -> Command:
        """Compute the command of one control period; NaN input never raises and never gives NaN wheel speeds.

        Args:
            pose: Pose of the robot, world frame.
            wheel_speeds: Present wheel linear speeds, shape (w,) [m/s], if they are not the last commanded ones; else
                None.
            reference: Reference to follow.
            period: Control period, for which the command holds [s].

        Returns:
            Command within the speed limit and within acceleration limit * period of the present speeds.

        Raises:
            InputError: The period is not positive, or the number of wheel speeds is wrong.
        """
        if not 0.0 < period < math.inf:
            raise InputError(f"a control period must be a positive time, found {period} s.")
        start = self._timer() if self._timer else math.nan
        rung: Rung = BRAKING
        wanted, cross, heading = self._rest, math.nan, math.nan
        known = wheel_speeds is None or self._take_over(wheel_speeds)
        if known and abs(pose.x) < FARTHEST and abs(pose.y) < FARTHEST and abs(pose.yaw) < FARTHEST:
            arrived, turning = self._predict(pose)
            preview = reference.sample(arrived, self._twist, self._times, self.settings.wheel_delay)
            cross, heading = preview.cross_track, preview.heading_error
            lead, stages = self._lead(period), np.asarray(preview.stages, float)
            if lead != 0.0:
                stages = _leading(stages, lead)
            if np.isfinite(stages).all():
                rung, wanted = self._plan_ahead(self._ahead(arrived, turning, lead), stages, period)
        if rung == BRAKING:
            self._plan = None
        self._wheels = self.drive.approach(self._wheels, wanted, period)
        self._twist = self.drive.twist(self._wheels)
        self._send(period)
        took = self._timer() - start if self._timer else math.nan
        return Command(self._wheels.copy(), rung, cross, heading, took)

    def _take_over(self, wheel_speeds: Array) -> bool:
        """Adopt measured wheel speeds; False if they are not finite."""
        speeds = np.asarray(wheel_speeds, dtype=float)
        if speeds.shape != self._wheels.shape:
            raise InputError(f"drive '{self.drive.name}' has wheels {self.drive.wheels}, found {speeds.size} speeds.")
        if not np.isfinite(speeds).all():
            return False
        self._wheels = self.drive.saturate(speeds)
        self._twist = self.drive.twist(self._wheels)
        self._turning = self._wheels
        return True

    def _lead(self, period: float) -> float:
        """Lead time of the plan before a command takes effect [s].

        If the wheels follow with a time constant T, the point p + T dp/dt moves as commanded, for pose p. The plan
        ramps the wheels to the command that is held from now on, so the command is half a period ahead of the plan.
        """
        return max(self.settings.wheel_lag - 0.5 * period, -self.settings.wheel_delay)

    def _ahead(self, pose: Pose2, turning: Array, lead: float) -> Pose2:
        """Point ahead of the robot that responds to the coming command without lag, as a pose.

        The plan is discarded if this pose has jumped since the last period.
        """
        ahead = pose
        if lead != 0.0:
            twist = self.drive.twist(turning)
            ahead = Pose2(*pose.transform(lead * twist.forward, lead * twist.left), pose.yaw + lead * twist.turn)
        before, self._pose = self._pose, ahead
        if before is not None and not before.distance(ahead) <= self.settings.jump:
            self._plan = None
        return ahead

    def _predict(self, pose: Pose2) -> tuple[Pose2, Array]:
        """Pose and modelled wheel speeds (w,) [m/s] when the coming command reaches the wheels."""
        turning = self._turning
        for time, wheels in self._sent:
            then, mean = self._respond(turning, wheels, time)
            pose, turning = _moved(pose, self.drive.twist(mean), time), then
        return Pose2(pose.x, pose.y, wrap_angle(pose.yaw)), turning

    def _send(self, period: float) -> None:
        """Queue the present command; apply queued commands older than the dead time to the modelled wheel speeds."""
        delay, lag = self.settings.wheel_delay, self.settings.wheel_lag
        if delay == lag == 0.0:
            return
        self._sent.append((period, self._wheels))
        left = sum(time for time, _ in self._sent) - delay
        while left > _INSTANT:
            time, wheels = self._sent.popleft()
            arrived = min(time, left)
            self._turning = self._respond(self._turning, wheels, arrived)[0]
            if time > left + _INSTANT:
                self._sent.appendleft((time - left, wheels))
            left -= arrived

    def _respond(self, turning: Array, wheels: Array, time: float) -> tuple[Array, Array]:
        """Model the response of the wheels to a command that is held for a time.

        Args:
            turning: Wheel speeds before, shape (w,) [m/s].
            wheels: Commanded wheel speeds, shape (w,) [m/s].
            time: Time [s].

        Returns:
            Wheel speeds after that time, and their mean over it, each of shape (w,) [m/s].
        """
        lag = self.settings.wheel_lag
        if lag == 0.0:
            return wheels, wheels
        decay, off = math.exp(-time / lag), turning - wheels
        return wheels + decay * off, wheels + (lag / time) * (1.0 - decay) * off

    def _plan_ahead(self, pose: Pose2, stages: Array, period: float) -> tuple[Rung, Array]:
        """Solve the quadratic program, or fall back to the previous plan or to braking.

        Args:
            pose: Pose from which the plan starts.
            stages: Reference, as in `Preview.stages`.
            period: Control period [s].

        Returns:
            Source of the command, and desired wheel speeds at the end of the period, shape (w,) [m/s].
        """
        if period != self._shift_period:
            times = np.concatenate([[0.0], self._layout.ends[1:]]) + period
            self._shift, self._shift_period = self._layout.interpolation(times), period
        q = self.drive.coordinates(self._wheels)
        # The starting point may have caused a failed solve, so the next one starts from the present speeds.
        start = q if self._plan is None or self._misses > 0 else self._plan[1:]
        rung: Rung = SOLVED
        nodes = self._program.solve(pose, q, start, stages)
        plan = nodes.ravel()
        if np.isfinite(plan).all() and (np.abs(self._rows.dot(plan)) <= TOLERANCE).all():
            self._misses, self._plan = 0, self._shift.dot(nodes)
        elif self._plan is not None and self._misses < self.settings.patience:
            rung, self._misses, self._plan = PREVIOUS, self._misses + 1, self._shift.dot(self._plan)
        else:
            return BRAKING, self._rest
        return rung, self.drive.wheels_from_q.dot(self._plan[0])


class _Program:
    """Compiled quadratic program with preallocated buffers, which reduce the call overhead from 100 us to 1 us."""

    def __init__(self, layout: Layout, settings: FollowerSettings) -> None:
        self._function = build(layout, settings.weights, settings.iterations)
        n, size = layout.n, layout.size
        # CasADi keeps bare pointers into these arrays: they must live as long as the buffer.
        self._input = np.zeros(self._function.numel_in(0))
        self._nodes = np.zeros((len(layout.blocks) + 1, n))
        self._output = self._nodes.reshape(-1)[n:]  # the nodes after the first
        self._start = self._input[3 + n : 3 + n + size].reshape(-1, n)
        self._wanted = self._input[3 + n + size :].reshape(layout.stages, 3 + n)
        self._q_from_twist = layout.drive.q_from_twist.T
        self._n = n
        self._buffer, self._trigger = self._function.buffer()
        self._buffer.set_arg(0, self._input.data)
        self._buffer.set_res(0, self._output.data)

    def solve(self, pose: Pose2, q: Array, start: Array, stages: Array) -> Array:
        """Solve the program.

        Args:
            pose: Pose of the robot, world frame.
            q: Present drive coordinates, shape (n,).
            start: Plan at which the problem is linearised, shape (blocks, n).
            stages: Reference, as in `Preview.stages`.

        Returns:
            Drive coordinates now and at the end of each block, shape (blocks + 1, n); NaN where the solver wrote
            nothing.
        """
        self._input[:3] = pose
        self._input[3 : 3 + self._n] = q
        self._start[:] = start
        self._wanted[:, :3] = stages[:, :3]
        self._wanted[:, 3:] = stages[:, 3:].dot(self._q_from_twist)
        self._output.fill(math.nan)
        self._trigger()
        self._nodes[0] = q
        return self._nodes


def _moved(pose: Pose2, twist: Twist2, time: float) -> Pose2:
    """Pose after a time [s] of a constant twist, by the midpoint rule; the yaw is not wrapped."""
    half = 0.5 * time * twist.turn
    x, y = Pose2(0.0, 0.0, pose.yaw + half).transform(time * twist.forward, time * twist.left)
    return Pose2(pose.x + x, pose.y + y, pose.yaw + 2.0 * half)


def _leading(stages: Array, lead: float) -> Array:
    """Reference stages (k, 6), each moved on by `lead` [s] of its own twist, to fit the pose that `_ahead` returns."""
    c, s = np.cos(stages[:, 2]), np.sin(stages[:, 2])
    moved = stages.copy()
    moved[:, 0] += lead * (c * stages[:, 3] - s * stages[:, 4])
    moved[:, 1] += lead * (s * stages[:, 3] + c * stages[:, 4])
    moved[:, 2] += lead * stages[:, 5]
    return moved
