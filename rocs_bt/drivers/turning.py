"""What a gyro makes of how a robot turns, the same in every backend."""

from __future__ import annotations

import math

import numpy as np

from ..geometry import wrap_angle
from .parameters import GyroParameters


class Turning:
    """Turns headings into readings of a gyro: the mean turn rate since the reading before, with its bias.

    The mean, not the rate at an instant: such a device samples itself a thousand times a second and adds up, so what
    a robot shakes between two readings is in it.

    Args:
        parameters: The gyro's.
        rng: Where its bias comes from.
    """

    def __init__(self, parameters: GyroParameters, rng: np.random.Generator) -> None:
        self._bias = parameters.bias * float(rng.normal())
        self._stamp = math.nan
        self._yaw = math.nan
        self._told = 0.0

    def look(self, stamp: float, yaw: float) -> float:
        """One reading [rad/s]; a second look at the same instant says the same.

        Args:
            stamp: When [s].
            yaw: Where the robot heads [rad]; less than half a turn from the reading before.
        """
        if stamp != self._stamp:
            passed = stamp - self._stamp
            rate = wrap_angle(yaw - self._yaw) / passed if passed > 0.0 else 0.0  # nothing came before the first
            self._stamp, self._yaw = stamp, yaw
            self._told = rate + self._bias
        return self._told
