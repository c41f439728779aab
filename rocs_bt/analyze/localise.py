"""Localise: pose estimation from odometry, gyro and fixes, without ground truth."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Annotated

import numpy as np

from ..base.geometry import Pose2
from ..base.signal import Signal
from ..base.units import (
    ANGLE,
    LENGTH,
    NOT_NEGATIVE,
    Metres,
    PositiveMetres,
    PositiveRadians,
    PositiveSeconds,
    Radians,
    RadiansPerSecond,
)
from ..control.locomotion import Array
from ..control.pose_filter import PoseFilter, PoseNoise
from ..declare import values_of
from ..event import Change
from ..interfaces.channel import Signals, Stamped
from .analyze import Analyze

FARTHEST = 1e6
"""Largest plausible coordinate [m]."""

_Length = Annotated[Metres, NOT_NEGATIVE]
_Rate = Annotated[RadiansPerSecond, NOT_NEGATIVE]
_UPPER = np.triu_indices(3)


class Localise(Analyze):
    """Writes `pose` and `goal_distance`, like a PoseMonitor, from the robot's own measurements.

    This is the paper's "localization algorithm running in the Analyze" (6.4), which replaces the simulator's position
    and orientation. It needs the signals of an OdometryMonitor and of a FixMonitor. The filter starts at the first
    sample with position and heading. Between fixes it propagates with wheels and gyro, or with the wheels alone if the
    gyro is invalid or missing.

    The signal `pose_spread` [m] is the standard deviation of the position along its major axis. `pose_covariance` is
    xx, xy, x yaw, yy, y yaw, yaw yaw. Without odometry nothing is written, so the pose becomes stale: fixes alone are
    too slow for control.

    Attributes:
        travel_noise: Standard deviation of the driven distance, after a metre [m].
        slip_noise: Standard deviation of the lateral slip, after a metre [m].
        turn_noise: Standard deviation of the wheels' heading, after a turn of a radian and after a metre [rad].
        gyro_noise: Standard deviation of the gyro's turn rate [rad/s].
        gyro_bias_noise: Standard deviation of the gyro's initial bias [rad/s].
        drift_noise: Standard deviation of the position's drift, after a second, independent of the motion [m].
        fix_position_noise: Standard deviation of each coordinate of a fix [m].
        fix_heading_noise: Standard deviation of the compass [rad].
        max_age: Validity of an estimate [s].
    """

    travel_noise: _Length = PoseNoise.travel
    slip_noise: _Length = PoseNoise.slip
    turn_noise: Annotated[Radians, NOT_NEGATIVE] = PoseNoise.turn
    gyro_noise: _Rate = PoseNoise.gyro
    gyro_bias_noise: _Rate = PoseNoise.gyro_bias
    drift_noise: _Length = PoseNoise.drift
    fix_position_noise: PositiveMetres = PoseNoise.fix_position
    fix_heading_noise: PositiveRadians = PoseNoise.fix_heading
    max_age: PositiveSeconds = 0.15

    def __post_init__(self) -> None:
        noises = {name.removesuffix("_noise"): value for name, value in values_of(self).items() if name != "max_age"}
        self._noise = PoseNoise(**noises)
        self._filter: PoseFilter | None = None
        self._travel: Array | None = None
        self._moved_at = -math.inf  # [s] time of the newest wheel travel

    def expects(self) -> Sequence[str]:
        return ("wheel_travel", "fix", "compass")

    def signals(self) -> Sequence[Signal]:
        age, square = self.max_age, LENGTH * LENGTH
        units = (square, square, LENGTH * ANGLE, square, LENGTH * ANGLE, ANGLE * ANGLE)
        return [
            Signal("pose", 3, (LENGTH, LENGTH, ANGLE), (-FARTHEST, FARTHEST), age, "x, y, yaw in the world frame."),
            Signal("goal_distance", 1, (LENGTH,), (0.0, math.inf), age, "Distance to the goal; +inf without."),
            Signal("pose_spread", 1, (LENGTH,), (0.0, math.inf), age, "Standard deviation of the position."),
            Signal("pose_covariance", 6, units, (-math.inf, math.inf), age, "Upper half of the pose's covariance."),
        ]

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        moved = False
        # At equal times the motion comes before the fix, in either order of the monitors.
        for sample in sorted(samples, key=lambda s: (s.t, "wheel_travel" not in s.value)):
            if "wheel_travel" in sample.value:
                moved = self._move(sample) or moved
            if self._filter is not None:
                self._correct(self._filter, sample.value)
            elif (begun := self._begin(sample.value)) is not None:
                self._filter = begun
                yield self.change(sample.t, "located", self.knowledge.agent, x=begun.pose.x, y=begun.pose.y)
        if self._filter is not None and moved:
            self._write(self._filter)

    def _begin(self, signals: Signals) -> PoseFilter | None:
        if "fix" not in signals or "compass" not in signals:
            return None
        start = Pose2(*signals["fix"], *signals["compass"])
        return PoseFilter(start, self._noise) if all(map(math.isfinite, start)) else None

    def _move(self, sample: Stamped[Signals]) -> bool:
        """Propagate the filter by the wheel travel since the last sample; False if the sample is invalid."""
        travel = np.array(sample.value["wheel_travel"])
        if not np.isfinite(travel).all():
            return False
        before, since = self._travel, self._moved_at
        self._travel, self._moved_at = travel, sample.t
        if self._filter is None or before is None or sample.t <= since:
            return True
        forward, turn, left = self.knowledge.robot.locomotion.twist(travel - before)
        dt = sample.t - since
        (rate,) = sample.value.get("gyro_rate", (math.nan,))
        self._filter.predict(forward, left, turn, dt, rate)
        if dt > self.max_age + 1e-6:  # the path during such a gap is unknown
            self._filter.widen(math.hypot(forward, left), abs(turn))
        return True

    def _correct(self, known: PoseFilter, signals: Signals) -> None:
        if "fix" in signals and all(map(math.isfinite, signals["fix"])):
            known.fix_position(*signals["fix"])
        if "compass" in signals and math.isfinite(signals["compass"][0]):
            known.fix_heading(signals["compass"][0])

    def _write(self, known: PoseFilter) -> None:
        x, y, yaw = known.pose
        goal, world = self.knowledge.world.pursued(), self.knowledge.world
        at = None if goal is None else world.pose_of(goal)
        self.write(
            self._moved_at,
            {
                "pose": [x, y, yaw],
                "goal_distance": [math.inf if at is None else math.hypot(at.x - x, at.y - y)],
                "pose_spread": [known.spread],
                "pose_covariance": known.covariance[:3, :3][_UPPER].tolist(),
            },
        )
