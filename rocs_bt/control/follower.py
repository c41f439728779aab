"""Trajectory follower: one small quadratic program per control period, with fallbacks if the solver fails.

The follower computes the next motion command from a reference and a pose in bounded time. Its commands are always
within the limits of the locomotion. The last fallback is a braking ramp, never an exception or NaN.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, Literal, TypeAlias

import numpy as np

from ..base.errors import InputError
from ..base.geometry import Pose2, Twist2, wrap_angle
from .follower_qp import Layout, Weights, build
from .locomotion import Array, Locomotion
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
        jump: Distance between the poses of two periods beyond which the plan is discarded, because the robot must have
            been carried [m].
    """

    blocks: tuple[int, ...] = (1, 1, 1, 2, 2, 3, 4, 6)
    dt: float = 0.1
    weights: Weights = field(default_factory=Weights)
    iterations: int = 200
    patience: int = 3
    jump: float = 0.5


@dataclass(frozen=True, eq=False)
class Command:
    """Command for the coming period, and its source.

    Attributes:
        values: Values of the motion command, shape (m,); for wheels their linear speeds [m/s].
        rung: Source of the command: `solved`, `previous plan` if the solver failed, or `braking` as the last fallback.
        cross_track: Cross-track error, left of the reference positive [m]; NaN if unknown.
        heading_error: Yaw minus the reference's [rad]; NaN if unknown.
        solve_time: Duration of this step by the injected timer [s]; NaN without a timer.
    """

    values: Array
    rung: Rung
    cross_track: float
    heading_error: float
    solve_time: float


class Follower:
    """Trajectory follower of one body.

    The follower assumes that the body moves as it commanded last, which makes every quadratic program feasible. Pass
    `measured` to `step` if something else, such as a reflex, has commanded the body since.

    Args:
        locomotion: Locomotion of the body.
        settings: Settings; None for the default ones.
        timer: Timer such as `time.perf_counter`, for `Command.solve_time` only [s].
    """

    def __init__(
        self,
        locomotion: Locomotion,
        settings: FollowerSettings | None = None,
        timer: Callable[[], float] | None = None,
    ) -> None:
        self.locomotion = locomotion
        self.settings = settings or FollowerSettings()
        self._delay, self._lag = locomotion.response.delay, locomotion.response.lag
        self._timer = timer
        self._layout = Layout(locomotion, self.settings.blocks, self.settings.dt)
        self._times = np.arange(1.0, self._layout.stages + 1.0) * self.settings.dt
        self._rows = np.vstack([self._layout.speed_rows, self._layout.acceleration_rows])
        self._shift, self._shift_period = np.eye(len(self.settings.blocks) + 1), math.nan
        self._rest = np.zeros(len(self.locomotion.values))
        self.reset()

    @cached_property
    def backward(self) -> Follower:
        """Follower for backward driving, in which a skid drive turns nearly about its base: no ICR offset."""
        return (
            self
            if self.locomotion.icr_offset == 0.0
            else Follower(self.locomotion.without_icr_offset, self.settings, self._timer)
        )

    @cached_property
    def _program(self) -> _Program:
        # Building takes as long as a thousand steps; an agent that is only checked never drives.
        return _Program(self._layout, self.settings)

    def prepare(self) -> None:
        """Build the quadratic programs of both directions now; on wall time no control period may wait for them."""
        for follower in (self, self.backward):
            follower._program  # noqa: B018 - a cached property

    def reset(self) -> None:
        """Reset plan, command and history to those of a robot at rest."""
        self._values = self._rest
        self._twist = Twist2(0.0)
        self._plan: Array | None = None  # (blocks + 1, n) nodes of q; the first is the last command
        self._misses = 0
        self._pose: Pose2 | None = None
        self._sent: deque[tuple[float, Array]] = deque()  # commands within the dead time, the oldest first
        self._turning = self._rest  # (m,) modelled values after the dead time

    def step(self, pose: Pose2, measured: Array | None, reference: Reference, period: float) -> Command:
        """Compute the command of one control period; NaN input never raises and never gives a NaN command.

        Args:
            pose: Pose of the robot, world frame.
            measured: Present values of the motion, shape (m,), such as wheel linear speeds [m/s], if they are not the
                last commanded ones; else None.
            reference: Reference to follow.
            period: Control period, for which the command holds [s].

        Returns:
            Command within the speed limit and within acceleration limit * period of the present values.

        Raises:
            InputError: The period is not positive, or the number of values is wrong.
        """
        if not 0.0 < period < math.inf:
            raise InputError(f"a control period must be a positive time, found {period} s.")
        start = self._timer() if self._timer else math.nan
        rung: Rung = BRAKING
        wanted, cross, heading = self._rest, math.nan, math.nan
        known = measured is None or self._take_over(measured)
        if known and abs(pose.x) < FARTHEST and abs(pose.y) < FARTHEST and abs(pose.yaw) < FARTHEST:
            arrived, turning = self._predict(pose)
            preview = reference.sample(arrived, self._twist, self._times, self._delay)
            cross, heading = preview.cross_track, preview.heading_error
            lead, stages = self._lead(period), np.asarray(preview.stages, float)
            if lead != 0.0:
                stages = _leading(stages, lead)
            if np.isfinite(stages).all():
                rung, wanted = self._plan_ahead(self._ahead(arrived, turning, lead), stages, period)
        if rung == BRAKING:
            self._plan = None
        self._values = self.locomotion.approach(self._values, wanted, period)
        self._twist = self.locomotion.twist(self._values)
        self._send(period)
        took = self._timer() - start if self._timer else math.nan
        return Command(self._values.copy(), rung, cross, heading, took)

    def start(self, pose: Pose2) -> tuple[Pose2, Twist2, float]:
        """Pose and commanded velocity when the next command takes effect, and the time until then [s]."""
        return self._predict(pose)[0], self._twist, self._delay

    def _take_over(self, measured: Array) -> bool:
        """Adopt measured values of the motion; False if they are not finite."""
        speeds = np.asarray(measured, dtype=float)
        if speeds.shape != self._values.shape:
            names = ", ".join(self.locomotion.values)
            raise InputError(f"a '{self.locomotion.kind}' locomotion has the values {names}, found {speeds.size}.")
        if not np.isfinite(speeds).all():
            return False
        self._values = self.locomotion.saturate(speeds)
        self._twist = self.locomotion.twist(self._values)
        self._turning = self._values
        return True

    def _lead(self, period: float) -> float:
        """Lead time of the plan before a command takes effect [s].

        If the motion follows with a time constant T, the point p + T dp/dt moves as commanded, for pose p. The plan
        ramps the values to the command that is held from now on, so the command is half a period ahead of the plan.
        """
        return max(self._lag - 0.5 * period, -self._delay)

    def _ahead(self, pose: Pose2, turning: Array, lead: float) -> Pose2:
        """Point ahead of the robot that responds to the coming command without lag, as a pose.

        The plan is discarded if this pose has jumped since the last period.
        """
        ahead = pose
        if lead != 0.0:
            twist = self.locomotion.twist(turning)
            ahead = Pose2(*pose.transform(lead * twist.forward, lead * twist.left), pose.yaw + lead * twist.turn)
        before, self._pose = self._pose, ahead
        if before is not None and not before.distance(ahead) <= self.settings.jump:
            self._plan = None
        return ahead

    def _predict(self, pose: Pose2) -> tuple[Pose2, Array]:
        """Pose and modelled values (m,) when the coming command takes effect."""
        turning = self._turning
        for time, values in self._sent:
            then, mean = self._respond(turning, values, time)
            pose, turning = _moved(pose, self.locomotion.twist(mean), time), then
        return Pose2(pose.x, pose.y, wrap_angle(pose.yaw)), turning

    def _send(self, period: float) -> None:
        """Queue the present command; apply queued commands older than the dead time to the modelled values.

        `_turning` models the motion at which the oldest queued command begins to act, so `_predict` goes on from there.
        A prediction by the dead time alone would over-correct, because a body with a lag does not follow at once.
        """
        delay, lag = self._delay, self._lag
        if delay == lag == 0.0:
            return
        self._sent.append((period, self._values))
        left = sum(time for time, _ in self._sent) - delay
        while left > _INSTANT:
            time, values = self._sent.popleft()
            arrived = min(time, left)
            self._turning = self._respond(self._turning, values, arrived)[0]
            if time > left + _INSTANT:
                self._sent.appendleft((time - left, values))
            left -= arrived

    def _respond(self, turning: Array, wanted: Array, time: float) -> tuple[Array, Array]:
        """Model the response of the body to a command that is held for a time.

        Args:
            turning: Values before, shape (m,).
            wanted: Commanded values, shape (m,).
            time: Time [s].

        Returns:
            Values after that time, and their mean over it, each of shape (m,).
        """
        lag = self._lag
        if lag == 0.0:
            return wanted, wanted
        decay, off = math.exp(-time / lag), turning - wanted
        return wanted + decay * off, wanted + (lag / time) * (1.0 - decay) * off

    def _plan_ahead(self, pose: Pose2, stages: Array, period: float) -> tuple[Rung, Array]:
        """Solve the quadratic program, or fall back to the previous plan or to braking.

        Args:
            pose: Pose from which the plan starts.
            stages: Reference, as in `Preview.stages`.
            period: Control period [s].

        Returns:
            Source of the command, and desired values at the end of the period, shape (m,).
        """
        if period != self._shift_period:
            times = np.concatenate([[0.0], self._layout.ends[1:]]) + period
            self._shift, self._shift_period = self._layout.interpolation(times), period
        q = self.locomotion.coordinates(self._values)
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
        return rung, self.locomotion.values_from_q.dot(self._plan[0])


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
        self._q_from_twist = layout.locomotion.q_from_twist.T
        self._n = n
        self._buffer, self._trigger = self._function.buffer()
        self._buffer.set_arg(0, self._input.data)
        self._buffer.set_res(0, self._output.data)

    def solve(self, pose: Pose2, q: Array, start: Array, stages: Array) -> Array:
        """Solve the program.

        Args:
            pose: Pose of the robot, world frame.
            q: Present coordinates, shape (n,).
            start: Plan at which the problem is linearised, shape (blocks, n).
            stages: Reference, as in `Preview.stages`.

        Returns:
            Coordinates now and at the end of each block, shape (blocks + 1, n); NaN where the solver wrote
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
