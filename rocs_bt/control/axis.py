"""One axis: rates that reach a target with limited rate and acceleration, for the yaw and for the height.

Source: the square-root law of time-optimal braking in discrete time; compare the tracking differentiator of Han, From
PID to active disturbance rejection control, IEEE Transactions on Industrial Electronics 56(3), 2009.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ..base.errors import InputError

Array: TypeAlias = npt.NDArray[np.float64]


@dataclass(frozen=True)
class AxisLimits:
    """Limits of one axis; its moves have trapezoidal rates and end at rest relative to their target.

    Attributes:
        max_speed: Limit of the rate in both directions [m/s or rad/s].
        max_acceleration: Limit of the acceleration [m/s2 or rad/s2].

    Raises:
        InputError: A limit is not a positive number.
    """

    max_speed: float
    max_acceleration: float

    def __post_init__(self) -> None:
        for name in ("max_speed", "max_acceleration"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} of an axis must be a positive number, found {getattr(self, name)}.")

    def step(self, error: float, rate: float, time: float, target_rate: float = 0.0, settling: float = 0.0) -> float:
        """Rate at the end of one time step; the rate changes linearly during the step.

        Args:
            error: Target at the end of the step minus the present position [m or rad].
            rate: Present rate [m/s or rad/s].
            time: Duration of the step [s].
            target_rate: Rate of the target [m/s or rad/s].
            settling: Minimum time constant of the approach, for a body that responds with a lag [s].

        Returns:
            Rate within the acceleration limit of the present one, and within the rate limit if the acceleration limit
            permits it [m/s or rad/s].
        """
        # Error at the end of the step if the step ends at the target's rate.
        left = error - 0.5 * (rate + target_rate) * time
        change = self.max_acceleration * time
        # The fastest approach from which the remaining steps can brake; close to the target, two steps end there.
        fastest = 0.5 * (math.sqrt(change * change + 8.0 * self.max_acceleration * abs(left)) - change)
        wanted = target_rate + math.copysign(min(fastest, abs(left) / max(time, settling)), left)
        wanted = min(max(wanted, -self.max_speed), self.max_speed)
        return min(max(wanted, rate - change), rate + change)

    def track(self, targets: Array, times: Array, position: float, rate: float) -> tuple[Array, Array]:
        """Positions and rates that follow targets.

        Args:
            targets: Target now and at each of the times, shape (k + 1,) [m or rad].
            times: Times from now on, ascending, shape (k,) [s].
            position: Present position [m or rad].
            rate: Present rate [m/s or rad/s].

        Returns:
            Positions and rates at the times, each of shape (k,); the positions are the integral of the rates.
        """
        positions, rates = np.empty(len(times)), np.empty(len(times))
        before, now = float(targets[0]), 0.0
        for k, (target, then) in enumerate(zip(targets[1:].tolist(), times.tolist(), strict=True)):
            time = then - now
            after = self.step(target - position, rate, time, (target - before) / time)
            position += 0.5 * (rate + after) * time
            positions[k], rates[k] = position, after
            rate, before, now = after, target, then
        return positions, rates
