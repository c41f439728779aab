"""The trajectory follower: one small quadratic program a control period, and a ladder for when it fails.

It turns a reference and a pose into the next wheel speeds. Its work is bounded, its commands keep the wheels' limits
whatever happens, and it ends in a braking ramp rather than in an exception or a NaN.
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
from .reference import Reference
from .tracking import Layout, Weights, build

Rung: TypeAlias = Literal["solved", "previous plan", "braking"]
SOLVED: Final = "solved"
PREVIOUS: Final = "previous plan"
BRAKING: Final = "braking"

_INSTANT = 1e-9  # [s] below which durations are rounding

FARTHEST = 1e6  # A pose with larger coordinates [m, rad] would overflow.
TOLERANCE = 1.01  # A plan may exceed a limit by so much before it counts as truncated; the final step cuts the rest.


@dataclass(frozen=True)
class FollowerSettings:
    """How the follower plans.

    Attributes:
        blocks: Lengths of the plan's pieces, in stages; their sum is the horizon.
        dt: Length of a stage [s].
        weights: What deviations cost.
        iterations: The most steps of the solver in a period.
        patience: Periods in a row that the previous plan may stand in for a failed one.
        wheel_delay: Dead time from a command until the wheels begin to follow it [s].
        wheel_lag: Time constant of the first-order lag with which the wheels then follow it [s].
        jump: A pose this much farther than the wheels can have driven means that the robot was carried [m].
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
        """By how much steadily changing wheel speeds are late behind their command [s]."""
        return self.wheel_delay + self.wheel_lag


@dataclass(frozen=True, eq=False)
class Command:
    """What to do in the coming period, and how it came about.

    Attributes:
        wheel_speeds: (w,) Rim speeds to command [m/s].
        rung: `solved`; `previous plan` when the solver failed; `braking` when nothing else was left.
        cross_track: Distance from the reference, left of it positive [m]; NaN when unknown.
        heading_error: Yaw minus the reference's [rad]; NaN when unknown.
        solve_time: What this step took by the injected timer [s]; NaN without one.
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
    """Follows references with one drive.

    The state of the wheels is what was commanded last, which makes every program feasible. Say `wheel_speeds` when
    somebody else drove since, such as a reflex.

    Args:
        drive: Whose wheels to command.
        settings: How to plan.
        timer: Read before and after each step to fill `Command.solve_time`, such as `time.perf_counter`; the follower
            itself never reads a clock.
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
        """Who follows while the robot drives backward: it turns nearly about its base, so there is no pivot."""
        return self if self.drive.pivot == 0.0 else Follower(self.drive.without_pivot, self.settings, self._timer)

    def reset(self) -> None:
        """Forget plan, wheels and history, as for a robot at rest."""
        self._wheels = self._rest
        self._twist = Twist2(0.0)
        self._plan: Array | None = None  # (blocks + 1, n) nodes of q, the first of them the last command
        self._misses = 0
        self._pose: Pose2 | None = None
        self._sent: deque[tuple[float, Array]] = deque()  # commands on the way to the wheels, the oldest first
        self._turning = self._rest  # (w,) modelled wheel speeds, of the commands that have arrived [m/s]

    def step(self, pose: Pose2, wheel_speeds: Array | None, reference: Reference, period: float) -> Command:
        """The command of one control period. Never raises on numbers, never returns NaN wheel speeds.

        Args:
            pose: The robot, in the world frame.
            wheel_speeds: (w,) Present rim speeds [m/s] when they are not those commanded last; else None.
            reference: What to follow.
            period: How long the command will hold [s].

        Returns:
            A command within the wheels' speed limit and within acceleration limit * period of the present speeds.
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
        """Adopt wheel speeds that somebody else commanded; False when they are not numbers."""
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
        """How far ahead of its arrival a command must be planned [s].

        Wheels that follow with a time constant T make a pose p of which p + T dp/dt moves as commanded. The plan ramps
        the wheels to the command that is held from now on, so the command itself is half a period ahead of the plan.
        """
        return max(self.settings.wheel_lag - 0.5 * period, -self.settings.wheel_delay)

    def _ahead(self, pose: Pose2, turning: Array, lead: float) -> Pose2:
        """The pose that answers the coming command at once; forgets the plan when the robot was carried off."""
        ahead = pose
        if lead != 0.0:
            twist = self.drive.twist(turning)
            ahead = Pose2(*pose.transform(lead * twist.forward, lead * twist.left), pose.yaw + lead * twist.turn)
        before, self._pose = self._pose, ahead
        if before is not None and not before.distance(ahead) <= self.settings.jump:
            self._plan = None
        return ahead

    def _predict(self, pose: Pose2) -> tuple[Pose2, Array]:
        """Pose and modelled wheel speeds (w,) [m/s] at the time when the coming command reaches the wheels."""
        turning = self._turning
        for time, wheels in self._sent:
            then, mean = self._respond(turning, wheels, time)
            pose, turning = _moved(pose, self.drive.twist(mean), time), then
        return Pose2(pose.x, pose.y, wrap_angle(pose.yaw)), turning

    def _send(self, period: float) -> None:
        """Put the present command on its way; what has arrived at the end of the period moves the modelled wheels."""
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
        """Wheel speeds after a time [s] of one command, and their mean meanwhile, (w,) each [m/s]."""
        lag = self.settings.wheel_lag
        if lag == 0.0:
            return wheels, wheels
        decay, off = math.exp(-time / lag), turning - wheels
        return wheels + decay * off, wheels + (lag / time) * (1.0 - decay) * off

    def _plan_ahead(self, pose: Pose2, stages: Array, period: float) -> tuple[Rung, Array]:
        """The rung reached, and the wheel speeds (w,) wanted at the end of the period [m/s]."""
        if period != self._shift_period:
            times = np.concatenate([[0.0], self._layout.ends[1:]]) + period
            self._shift, self._shift_period = self._layout.interpolation(times), period
        q = self.drive.coordinates(self._wheels)
        # A failed solve may have come from its own starting point: begin the next one afresh.
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
    """The compiled program with its buffers; calling it through them costs a microsecond instead of a hundred."""

    def __init__(self, layout: Layout, settings: FollowerSettings) -> None:
        self._function = build(layout, settings.weights, settings.iterations)
        n, size = layout.n, layout.size
        # CasADi keeps bare pointers into these arrays, so they live as long as the buffer does.
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
        """(blocks + 1, n) Nodes of the plan from q on; NaN where the solver wrote nothing."""
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
    """The pose after a time [s] of a steady twist, by the midpoint rule; its yaw goes on beyond pi."""
    half = 0.5 * time * twist.turn
    x, y = Pose2(0.0, 0.0, pose.yaw + half).transform(time * twist.forward, time * twist.left)
    return Pose2(pose.x + x, pose.y + y, pose.yaw + 2.0 * half)


def _leading(stages: Array, lead: float) -> Array:
    """Stages (k, 6) for the pose that answers commands at once: each moved on by `lead` [s] of its own twist."""
    c, s = np.cos(stages[:, 2]), np.sin(stages[:, 2])
    moved = stages.copy()
    moved[:, 0] += lead * (c * stages[:, 3] - s * stages[:, 4])
    moved[:, 1] += lead * (s * stages[:, 3] + c * stages[:, 4])
    moved[:, 2] += lead * stages[:, 5]
    return moved
